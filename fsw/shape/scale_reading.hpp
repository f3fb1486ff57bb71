// Reads a configured length or range in the map.
#pragma once

#include <cstdint>

#include "geometry/camera_model.hpp"
#include "map/map_state.hpp"
#include "shape/scale_state.hpp"

namespace polhode {

/// Input of a reading beside the map.
struct ScaleInput {
  const ScaleOptions* options = nullptr;
  const CameraModel* camera = nullptr;
};

/// Reads the scale in this frame, with its pose and landmarks.
ScaleChange read_scale_in_frame(const MapState& map, const ScaleInput& input, ScaleState* scale);

/// Reads the scale in the keyframe of the configured time; nothing where there is none.
ScaleChange read_scale_in_keyframe(const MapState& map, const ScaleInput& input, ScaleState* scale);

/// Reads the scale in the configured frame, which is this one or a keyframe, when a reading is due.
/// A repeated reading that fails, or has no smaller sigma, is counted, and due again when the map
/// has grown.
ScaleChange read_scale(std::int64_t timestamp_ns,
                       const MapState& map,
                       const ScaleInput& input,
                       ScaleState* scale);

}  // namespace polhode
