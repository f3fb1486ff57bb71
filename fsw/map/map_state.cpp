#include "map/map_state.hpp"

namespace polhode {

LocaliseInput localise_input(const MapInput& input, const Map& map) {
  return {.map = &map,
          .features = input.features,
          .camera = input.camera,
          .image_motion = input.image_motion,
          .options = input.localise,
          .ratio_max = input.tracks->descriptor_ratio_max,
          .seed = input.seed,
          .stream = input.frame};
}

void begin_frame(MapState* state) {
  state->pyramid.built = false;
  state->localised.matches.clear();
  state->pose_valid = false;
  state->pose_updates_motion = true;
  state->inconsistency = PoseCovariance::Zero();
  state->moved_rad = 0.0;
}

void drop_reference(MapState* state) { state->reference.valid = false; }

void reset_map(MapState* state) {
  clear(&state->map);
  state->drift = {};
  state->growth = {};
  state->last_adjustment_of_all = {};
  state->reference.valid = false;
  state->reference.points.clear();
  state->localised.matches.clear();
  state->pose_valid = false;
  state->pose_updates_motion = true;
  state->inconsistency = PoseCovariance::Zero();
  state->before = {};
}

}  // namespace polhode
