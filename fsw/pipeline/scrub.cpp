#include "pipeline/scrub.hpp"

#include "base/sound.hpp"
#include "bus/event_reports.hpp"
#include "bus/mend.hpp"
#include "map/mend.hpp"
#include "map/soundness.hpp"
#include "motion/mend.hpp"
#include "motion/soundness.hpp"
#include "pipeline/mend_parameters.hpp"
#include "pipeline/reset.hpp"
#include "pipeline/state.hpp"
#include "shape/soundness.hpp"

namespace polhode {
namespace {

void tell(std::string_view table, const Mended& mended, Component::State* s) {
  ++s->bus.tables_damaged;
  bus::event::table_damaged({.table = table,
                             .entries = static_cast<std::uint32_t>(mended.entries),
                             .reset = mended.reset},
                            &s->bus.events);
}

void scrub_configuration(Component::State* s) {
  Configuration& c = s->configuration;
  const Mended mended = mend_parameters(&c);
  if (mended.reset) {
    reset_target(s);
  }
  if (mended.any()) {
    tell("parameter table", mended, s);
  }
  c.spare = c.parameters;
  c.camera = to_model(c.parameters.camera);
}

void scrub_mode(Component::State* s) {
  const bool known = sound::is_enum(s->mode.now, kLastMode);
  const bool held = sound::mend(&s->mode.held);
  const bool mended = sound::mend(&s->clock.time_known) || held;
  if (!known) {
    s->mode.now = Mode::kIdle;
    reset_target(s);
  }
  if (mended || !known) {
    tell("mode", {.entries = 1, .reset = !known}, s);
  }
}

/// The map, with the drift, which nothing else tells; the motion, which rests on both.
void scrub_map(Component::State* s) {
  MapState& mapping = s->mapping;
  const std::int64_t now_ns = s->clock.timestamp_ns;
  Mended map = mend(s->configuration.camera, now_ns, &mapping.map);
  if (!is_sound(mapping.drift)) {
    map = {.entries = map.entries + 1, .reset = true};
  }
  if (map.reset) {
    reset_target(s);
  }
  if (map.any()) {
    drop_reference(&mapping);  // it may follow landmarks that have gone
    tell("map", map, s);
  }
  if (!is_sound(mapping.reference, mapping.map)) {
    mapping.reference.valid = false;
    mapping.reference.gray_to_come = false;
    mapping.reference.pose = {};
    mapping.reference.points.clear();
    tell("flow reference", {.entries = 1, .reset = true}, s);
  }
  const Mended motion = mend(now_ns, &s->motion);
  if (motion.any()) {
    invalidate_fits(&s->jobs);
    tell("motion", motion, s);
  }
}

void scrub_rest(Component::State* s) {
  if (!is_sound(s->initialisation)) {
    clear(&s->initialisation);
    invalidate_start(&s->jobs);
    tell("tracks", {.reset = true}, s);
  }
  if (!is_sound(s->features.resting)) {
    s->features.resting.places.clear();
    tell("resting places", {.reset = true}, s);
  }
  if (!is_sound(s->shape)) {
    s->shape = {};
    tell("shape", {.reset = true}, s);
  }
  if (!is_sound(s->scale)) {
    s->scale = {};
    tell("scale", {.reset = true}, s);
  }
  if (!is_sound(s->camera)) {
    s->camera = {};
    tell("test of the camera", {.reset = true}, s);
  }
  if (const Mended bus = mend(&s->bus); bus.any()) {
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
