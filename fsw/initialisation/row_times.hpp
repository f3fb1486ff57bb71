// Row times of a rolling shutter before there is a map: the image motion is that of the tracks.
#pragma once

#include "geometry/camera_model.hpp"
#include "tracks/track_table.hpp"

namespace polhode {

/// Brings the newest frame's features to the frame's time, by the motion since the last frame of
/// the tracks that end in it. The first frame is corrected with the second. Does nothing where all
/// rows are of one time.
void to_frame_time(const CameraModel& camera, TrackTable* table);

}  // namespace polhode
