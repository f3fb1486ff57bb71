// Which adjustments of the map are asked for, and with what.
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

/// What an adjustment is prepared from beside the map. Pointers are never null.
struct AdjustmentView {
  const MotionEstimate* motion = nullptr;
  const Parameters* parameters = nullptr;
  const CameraModel* camera = nullptr;
  bool short_of_memory = false;
  std::int64_t now_ns = 0;  ///< nothing in the map is later
  JobTimes times;
};

/// Copies all of the map, with its motion where that is one of free bodies: paper mode knows no
/// dynamics, and what is to be forgotten must not shape the map.
void prepare_adjustment_of_all(const AdjustmentView& view, MapState* mapping, AdjustmentJob* job);

/// Asks for an adjustment of all of the map.
void ask_for_adjustment_of_all(AdjustmentReason reason,
                               const AdjustmentView& view,
                               MapState* mapping,
                               JobQueue* queue);

/// Asks for the adjustment after the last keyframes, when there are new ones and no other work of
/// the map is out: of a window, or of all keyframes where a loop has closed or the map has grown by
/// a fifth since that was done last.
void ask_for_adjustment_after_growth(const AdjustmentView& view,
                                     MapState* mapping,
                                     JobQueue* queue);

/// One round, and no loop that closes: for an adjustment here and now.
void set_rounds(int iterations_max, const MapOptions& options, AdjustmentJob* job);

}  // namespace polhode
