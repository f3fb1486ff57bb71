#include "pipeline/scrub.hpp"

#include "base/validity.hpp"
#include "bus/event_reports.hpp"
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

void report_damage(std::string_view table, const Repair& repaired, BusState* bus) {
  ++bus->tables_damaged;
  bus::event::table_damaged({.table = table,
                             .entries = static_cast<std::uint32_t>(repaired.entries),
                             .reset = repaired.reset},
                            &bus->events);
}

/// @return whether the target is to be reset.
bool scrub_configuration(Configuration* c, BusState* bus) {
  const Repair repaired = mend_parameters(c);
  if (repaired.any()) {
    report_damage("parameter table", repaired, bus);
  }
  c->spare = c->parameters;
  c->camera = to_model(c->parameters.camera);
  return repaired.reset;
}

/// @return whether the target is to be reset.
bool scrub_mode(FrameClock* clock, ModeState* mode, BusState* bus) {
  const bool known = validity::is_enum(mode->now, kLastMode);
  const bool held = validity::repair(&mode->held);
  const bool repaired = validity::repair(&clock->time_known) || held;
  if (!known) {
    mode->now = Mode::kIdle;
  }
  if (repaired || !known) {
    report_damage("mode", {.entries = 1, .reset = !known}, bus);
  }
  return !known;
}

/// The map, with its drift, which no other table can restore.
/// @return whether the target is to be reset.
bool scrub_map(const CameraModel& camera, std::int64_t now_ns, MapState* mapping, BusState* bus) {
  Repair map = repair(camera, now_ns, &mapping->map);
  if (!is_valid(mapping->drift)) {
    map = {.entries = map.entries + 1, .reset = true};
  }
  if (map.any()) {
    drop_reference(mapping);  // it may follow landmarks that were removed
    report_damage("map", map, bus);
  }
  return map.reset;
}

/// Tables that depend on the map: the reference of optical flow, and the motion.
void scrub_motion(
    std::int64_t now_ns, MapState* mapping, MotionEstimate* motion, JobQueue* jobs, BusState* bus) {
  if (!is_valid(mapping->reference, mapping->map)) {
    mapping->reference.valid = false;
    mapping->reference.gray_to_come = false;
    mapping->reference.pose = {};
    mapping->reference.points.clear();
    report_damage("flow reference", {.entries = 1, .reset = true}, bus);
  }
  const Repair repaired = repair(now_ns, motion);
  if (repaired.any()) {
    invalidate_fits(jobs);
    report_damage("motion", repaired, bus);
  }
}

void scrub_tracks(InitialisationState* initialisation, JobQueue* jobs, BusState* bus) {
  if (!is_valid(*initialisation)) {
    clear(initialisation);
    invalidate_start(jobs);
    report_damage("tracks", {.reset = true}, bus);
  }
}

/// A table that no other depends on.
template <typename Table>
void scrub_table(std::string_view name, Table* table, BusState* bus) {
  if (!is_valid(*table)) {
    *table = {};
    report_damage(name, {.reset = true}, bus);
  }
}

}  // namespace

void scrub(Component::State* s) {
  const auto reset_if = [s](bool damaged) {
    if (damaged) {
      reset_target(s);
    }
  };
  BusState* bus = &s->bus;
  const std::int64_t now_ns = s->clock.timestamp_ns;
  reset_if(scrub_configuration(&s->configuration, bus));
  reset_if(scrub_mode(&s->clock, &s->mode, bus));
  reset_if(scrub_map(s->configuration.camera, now_ns, &s->mapping, bus));
  scrub_motion(now_ns, &s->mapping, &s->motion, &s->jobs, bus);
  scrub_tracks(&s->initialisation, &s->jobs, bus);
  scrub_table("resting places", &s->features.resting, bus);
  scrub_table("shape", &s->shape, bus);
  scrub_table("scale", &s->scale, bus);
  scrub_table("test of the camera", &s->camera, bus);
  if (const Repair repaired = repair(bus); repaired.any()) {
    report_damage("bus", repaired, bus);
  }
}

}  // namespace polhode
