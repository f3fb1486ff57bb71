// An adjustment of the map, as work apart from the step.
#pragma once

#include <cstdint>

#include "base/fixed_vector.hpp"
#include "base/ids.hpp"
#include "map/window.hpp"
#include "motion/joint_fit.hpp"
#include "motion/rigid_model.hpp"

namespace polhode {

/// Reason of an adjustment. It decides the next step of the map.
enum class AdjustmentReason : std::uint8_t { kMapBegun, kMapCompleted, kMapGrown };

/// A joint adjustment of part of the map, in rounds, each with its own loss. Then, on request, one
/// of the whole map as a free body, kept where the images support it.
struct AdjustmentJob {
  static constexpr std::size_t kRounds = 3;  ///< after a loop closure; else one round
  AdjustmentReason reason = AdjustmentReason::kMapGrown;
  bool closed = false;  ///< a loop was closed
  bool of_all = false;  ///< of the whole map
  KeyframeId keyframe;  ///< newest one when the job was prepared
  std::uint32_t keyframe_number = 0;
  std::uint32_t first_keyframe = 0;  ///< number of the first one of the new part of the map
  FixedVector<BundleOptions, kRounds> rounds;
  AdjustmentSnapshot snapshot;  ///< in: the map; out: the adjusted map
  bool usable = false;          ///< the result may be taken

  bool as_free_body = false;
  bool model_unwanted = false;  ///< the motion so far has been invalidated since
  double body_radius_mu = 1.0;
  MotionOptions motion;
  RigidModel model;                 ///< in: the last one; out: of this map, where accepted
  std::uint32_t marginal_fits = 0;  ///< carried from one fit to the next
  JointFitWorkspace joint;
};

/// A pure function of the snapshot.
void run_adjustment(AdjustmentJob* job);

/// For a job that finds no memory: returns it without a result.
void skip_adjustment(AdjustmentJob* job);

}  // namespace polhode
