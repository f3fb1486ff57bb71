// Requests adjustments of the map and prepares their input.
#pragma once

#include <cstdint>

#include "map/options.hpp"
#include "pipeline/job_times.hpp"

namespace polhode {

enum class AdjustmentReason : std::uint8_t;
struct AdjustmentJob;
struct CameraModel;
struct JobQueue;
struct MapState;
struct MotionEstimate;
struct Parameters;

/// Input of an adjustment beside the map. Pointers are never null.
struct AdjustmentView {
  const MotionEstimate* motion = nullptr;
  const Parameters* parameters = nullptr;
  const CameraModel* camera = nullptr;
  bool short_of_memory = false;
  std::int64_t now_ns = 0;  ///< nothing in the map is later
  JobTimes times;
};

/// Copies the whole map. The motion takes part only as that of a free body: paper mode has no
/// dynamics, and a motion fitted with decaying weights must not shape the map.
void prepare_adjustment_of_all(const AdjustmentView& view, MapState* mapping, AdjustmentJob* job);

/// Requests an adjustment of the whole map.
void ask_for_adjustment_of_all(AdjustmentReason reason,
                               const AdjustmentView& view,
                               MapState* mapping,
                               JobQueue* queue);

/// Requests an adjustment after new keyframes, unless other work of the map is out. It is of a
/// window; of all keyframes after a loop closure, or once a fifth of them are new since the last
/// such adjustment.
void ask_for_adjustment_after_growth(const AdjustmentView& view,
                                     MapState* mapping,
                                     JobQueue* queue);

/// One round with the narrow loss, without a loop closure: for an adjustment that runs at once.
void set_rounds(int iterations_max, const MapOptions& options, AdjustmentJob* job);

}  // namespace polhode
