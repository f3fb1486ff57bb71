// An adjustment of the map, as work apart from the step.
#pragma once

#include <cstdint>

#include "base/fixed_vector.hpp"
#include "base/ids.hpp"
#include "map/window.hpp"
#include "motion/joint_fit.hpp"
#include "motion/rigid_model.hpp"

namespace polhode {

/// What an adjustment is for, which decides what follows from it.
enum class AdjustmentReason : std::uint8_t { kMapBegun, kMapCompleted, kMapGrown };

/// A joint adjustment of part of the map, in rounds with a loss of their own; then, where asked
/// for, of all of it as a free body's, which is kept where the images confirm it.
struct AdjustmentJob {
  static constexpr std::size_t kRounds = 3;  ///< a closed loop's; others have one
  AdjustmentReason reason = AdjustmentReason::kMapGrown;
  bool closed = false;  ///< a loop
  bool of_all = false;  ///< of the whole map
  KeyframeId keyframe;  ///< newest one that the map has grown by
  std::uint32_t keyframe_number = 0;
  std::uint32_t first_keyframe = 0;  ///< number of the first one of the part that has begun
  FixedVector<BundleOptions, kRounds> rounds;
  AdjustmentSnapshot snapshot;  ///< in: as the map is; out: as it should be
  bool usable = false;          ///< of the result

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

/// There is no memory for it: it comes back without a result.
void skip_adjustment(AdjustmentJob* job);

}  // namespace polhode
