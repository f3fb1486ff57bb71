#include "features/row_times.hpp"

namespace polhode {

void to_frame_time(const CameraModel& camera, const ImageMotion& motion, Features* features) {
  if (camera.line_time_s == 0.0) {
    return;
  }
  for (Feature& f : *features) {
    f.normalised = at_frame_time(camera, motion, {f.u_px, f.v_px});
  }
}

}  // namespace polhode
