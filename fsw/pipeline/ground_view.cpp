#include "pipeline/ground_view.hpp"

#include "pipeline/state.hpp"

namespace polhode {

bool motion_is_of_map(const Component& component) {
  return motion_is_of_map(*ComponentAccess::state(component));
}

bool motion_is_of_map(const Component::State& s) {
  const AdjustmentJob& last = s.jobs.adjustment;
  return last.as_free_body && last.model.accepted() && s.motion.model.of_map;
}

GroundView view_of(const Component& component) {
  return view_of(*ComponentAccess::state(component));
}

GroundView view_of(const Component::State& s) {
  return {.parameters = s.configuration.parameters,
          .camera = s.configuration.camera,
          .gray = s.picture.gray,
          .mask = s.picture.mask,
          .mask_state = s.picture.mask_state,
          .initialisation = s.initialisation,
          .map = s.mapping.map,
          .drift = s.mapping.drift,
          .last_pose = s.mapping.localised.absolute.pose,
          .model = s.motion.model,
          .moves_so_since_ns = s.motion.moves_so_since_ns,
          .scale = s.scale,
          .scale_number = number_of(lengths_unit(s), s.bus.scale),
          .camera_found = s.camera.found,
          .target_frame = s.mapping.target_frame};
}

}  // namespace polhode
