#include "pipeline/scrub.hpp"

#include "base/validity.hpp"
#include "bus/mend.hpp"
#include "map/repair.hpp"
#include "map/validity.hpp"
#include "motion/mend.hpp"
#include "motion/soundness.hpp"
#include "pipeline/mend_parameters.hpp"
#include "pipeline/reset.hpp"
#include "pipeline/state.hpp"
#include "shape/validity.hpp"

namespace polhode {
namespace {

void tell(std::string_view table, const Repair& repaired, Component::State* s) {
  ++s->bus.tables_damaged;
  bus::report(bus::EventId::kTableDamaged,
              {.values = {static_cast<double>(repaired.entries), repaired.reset ? 1.0 : 0.0},
               .word = table},
              &s->bus.events);
}

void scrub_configuration(Component::State* s) {
  Configuration& c = s->configuration;
  const Repair repaired = mend_parameters(&c);
  if (repaired.reset) {
    reset_target(s);
  }
  if (repaired.any()) {
    tell("parameter table", repaired, s);
  }
  c.spare = c.parameters;
  c.camera = to_model(c.parameters.camera);
}

void scrub_mode(Component::State* s) {
  const bool known = validity::is_enum(s->mode.now, kLastMode);
  const bool held = validity::repair(&s->mode.held);
  const bool repaired = validity::repair(&s->clock.time_known) || held;
  if (!known) {
    s->mode.now = Mode::kIdle;
    reset_target(s);
  }
  if (repaired || !known) {
    tell("mode", {.entries = 1, .reset = !known}, s);
  }
}

/// The map, with the drift, which nothing else tells; the motion, which rests on both.
void scrub_map(Component::State* s) {
  MapState& mapping = s->mapping;
  const std::int64_t now_ns = s->clock.timestamp_ns;
  Repair map = repair(s->configuration.camera, now_ns, &mapping.map);
  if (!is_valid(mapping.drift)) {
    map = {.entries = map.entries + 1, .reset = true};
  }
  if (map.reset) {
    reset_target(s);
  }
  if (map.any()) {
    drop_reference(&mapping);  // it may follow landmarks that have gone
    tell("map", map, s);
  }
  if (!is_valid(mapping.reference, mapping.map)) {
    mapping.reference.valid = false;
    mapping.reference.gray_to_come = false;
    mapping.reference.pose = {};
    mapping.reference.points.clear();
    tell("flow reference", {.entries = 1, .reset = true}, s);
  }
  const Repair motion = repair(now_ns, &s->motion);
  if (motion.any()) {
    invalidate_fits(&s->jobs);
    tell("motion", motion, s);
  }
}

void scrub_rest(Component::State* s) {
  if (!is_valid(s->initialisation)) {
    clear(&s->initialisation);
    invalidate_start(&s->jobs);
    tell("tracks", {.reset = true}, s);
  }
  if (!is_valid(s->features.resting)) {
    s->features.resting.places.clear();
    tell("resting places", {.reset = true}, s);
  }
  if (!is_valid(s->shape)) {
    s->shape = {};
    tell("shape", {.reset = true}, s);
  }
  if (!is_valid(s->scale)) {
    s->scale = {};
    tell("scale", {.reset = true}, s);
  }
  if (!is_valid(s->camera)) {
    s->camera = {};
    tell("test of the camera", {.reset = true}, s);
  }
  if (const Repair bus = repair(&s->bus); bus.any()) {
    tell("bus", bus, s);
  }
}

}  // namespace

void scrub(Component::State* s) {
  scrub_configuration(s);
  scrub_mode(s);
  scrub_map(s);
  scrub_rest(s);
}

}  // namespace polhode
