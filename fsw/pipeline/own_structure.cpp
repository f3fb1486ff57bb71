#include "pipeline/own_structure.hpp"

#include "base/assert.hpp"
#include "pipeline/state.hpp"

namespace polhode {

void set_own_structure(const OwnStructure* own, Component* component) {
  Component::State* s = ComponentAccess::state(*component);
  const CameraModel& camera = s->configuration.camera;
  POLHODE_ASSERT(
      own == nullptr || own->pixels.size() == cv::Size(camera.width_px, camera.height_px),
      camera.width_px);
  s->picture.own = own;
}

}  // namespace polhode
