#include "pipeline/reset.hpp"

#include "pipeline/state.hpp"

namespace polhode {

void reset_map_and_motion(Component::State* s) {
  reset_map(&s->mapping);
  reset_poses(&s->motion);
  s->shape = {};
  s->bus.predictions.walk.under_way = false;
  invalidate_all(&s->jobs);
}

void reset_target(Component::State* s) {
  reset_map_and_motion(s);
  clear(&s->initialisation);
  s->scale = {};
  reset_pictures(&s->picture);
  s->bus.cloud.points_T.clear();
  s->bus.cloud.next = 0;
  change_mode(ModeEvent::kTargetReset, &s->mode);
}

void pause(Component::State* s) {
  drop_reference(&s->mapping);
  clear(&s->initialisation);
  invalidate_start(&s->jobs);
  reset_pictures(&s->picture);
}

}  // namespace polhode
