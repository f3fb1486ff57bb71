#include "pipeline/reset.hpp"

namespace polhode {

void forget_map(Component::State* s) {
  reset_map(&s->mapping);
  forget_poses(&s->motion);
  s->shape = {};
  s->bus.predictions.walk.under_way = false;
  s->jobs.last_adjustment_of_all = {};
  invalidate_all(&s->jobs);
}

void forget_target(Component::State* s) {
  forget_map(s);
  clear(&s->initialisation.tracks);
  forget_scale(&s->scale);
  forget_pictures(&s->picture);
  s->bus.cloud.points_T.clear();
  s->bus.cloud.next = 0;
  change_mode(ModeEvent::kTargetReset, &s->mode);
}

void pause(Component::State* s) {
  drop_reference(&s->mapping);
  clear(&s->initialisation.tracks);
  invalidate_start(&s->jobs);
  forget_pictures(&s->picture);
}

}  // namespace polhode
