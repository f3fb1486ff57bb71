#include "pipeline/commands.hpp"

#include <algorithm>

#include "base/crc.hpp"
#include "base/earlier_times.hpp"
#include "base/validity.hpp"
#include "bus/commands.hpp"
#include "bus/dynamics_telemetry.hpp"
#include "bus/event_reports.hpp"
#include "motion/disturbance.hpp"
#include "pipeline/parameter_image.hpp"
#include "pipeline/point_question.hpp"
#include "pipeline/reset.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

namespace event = bus::event;

using bus::Command;
using bus::Refusal;
using bus::Rejection;

/// Outcome of a well-formed command: empty when done, else the reason of its refusal.
using Outcome = std::string_view;
constexpr Outcome kDone{};

/// Frames after this command are not processed.
Outcome hold_frames(ModeState* mode) {
  if (mode->held) {
    return "held already";
  }
  mode->held = true;
  change_mode(ModeEvent::kHoldCommanded, mode);
  return kDone;
}

Outcome resume_frames(const Map& map, ModeState* mode) {
  if (!mode->held) {
    return "not held";
  }
  mode->held = false;
  const bool has_map = map.landmark_count > 0;
  change_mode(has_map ? ModeEvent::kResumedWithMap : ModeEvent::kResumedWithoutMap, mode);
  return kDone;
}

/// Length and range share the frame that they are read in, so each replaces the other, once it can
/// be read.
Outcome scale_read_in(std::int64_t frame_timestamp_ns, Configuration* c, ScaleState* state) {
  c->parameters.scale.frame_timestamp_ns = frame_timestamp_ns;
  c->table_crc = table_crc(c->parameters);
  state->keyframes_at_reading = 0;
  return kDone;
}

Outcome set_known_length(const Command& command, Configuration* c, ScaleState* state) {
  const auto length = command.arguments<bus::SetKnownLengthCommand>();
  const auto inside = [&](const std::array<double, 2>& px) {
    return px[0] <= c->camera.width_px - 0.5 && px[1] <= c->camera.height_px - 0.5;
  };
  if (!inside(length.first_px) || !inside(length.second_px)) {
    return "point outside the image";
  }
  ScaleOptions& scale = c->parameters.scale;
  scale.known_length_m = length.length_m;
  scale.points_px = {length.first_px, length.second_px};
  scale.range_m = 0.0;
  return scale_read_in(length.frame_timestamp_ns, c, state);
}

Outcome set_range(const Command& command, Configuration* c, ScaleState* state) {
  const auto range = command.arguments<bus::SetRangeCommand>();
  c->parameters.scale.range_m = range.range_m;
  c->parameters.scale.known_length_m = 0.0;
  return scale_read_in(range.frame_timestamp_ns, c, state);
}

Outcome take_attitude(const Command& command, ServicerAttitude* servicer) {
  const auto reported = command.arguments<bus::ServicerAttitudeCommand>();
  if (!validity::is_time(reported.timestamp_ns)) {
    return "time is beyond the year 2116";
  }
  if (servicer->known && reported.timestamp_ns <= servicer->timestamp_ns &&
      !outvotes(reported.timestamp_ns, &servicer->doubt)) {
    return "time does not increase";
  }
  *servicer = {.known = true,
               .timestamp_ns = reported.timestamp_ns,
               .q_IC = Eigen::Quaterniond(
                           reported.q_IC[0], reported.q_IC[1], reported.q_IC[2], reported.q_IC[3])
                           .normalized(),
               .w_C_rad_s = {reported.w_C_rad_s[0], reported.w_C_rad_s[1], reported.w_C_rad_s[2]}};
  return kDone;
}

/// @param now_ns  of the last frame that was looked at: landmarks are as they were then.
Outcome request_cloud(const Command& command,
                      std::int64_t now_ns,
                      const Map& map,
                      const ScaleState& scale,
                      BusState* bus) {
  const auto request = command.arguments<bus::RequestCloudCommand>();
  const auto in_map = static_cast<std::size_t>(map.landmark_count);
  if (in_map == 0) {
    return "no map";
  }
  CloudRequest& cloud = bus->cloud;
  cloud.points_T.clear();
  cloud.next = 0;
  ++cloud.number;
  cloud.timestamp_ns = now_ns;
  cloud.scale_known = scale.known;
  cloud.metres_per_mu = scale.metres_per_mu;
  const std::size_t wanted = std::min<std::size_t>(request.points_max, in_map);
  std::size_t seen = 0;
  for (const Landmark& landmark : map.landmarks) {
    if (!landmark.used) {
      continue;
    }
    // Evenly over the map's slots: every in_map / wanted-th one.
    const bool taken = seen * wanted / in_map != (seen + 1) * wanted / in_map;
    ++seen;
    if (taken) {
      const Eigen::Vector3f p = (cloud.metres_per_mu * landmark.p_T).cast<float>();
      (void)cloud.points_T.push_back({p.x(), p.y(), p.z()});
    }
  }
  const std::size_t points = cloud.points_T.size();
  event::cloud_begun({.points = static_cast<std::uint32_t>(points),
                      .packets = static_cast<std::uint32_t>(chunks_of(points))},
                     &bus->events);
  return kDone;
}

Outcome load_table(const Command& command, Configuration* c, bus::EventLog* events) {
  InactiveTable& table = c->inactive;
  Parameters changed = table.begun ? table.parameters : c->parameters;
  for (std::size_t i = 0; i < command.entries; ++i) {
    const bus::TableLoadEntry entry = command.entry(i);
    const ParameterRow* row = find_parameter_by_crc(entry.key_crc);
    const bool good = row != nullptr && may_change_in_flight(row->key) &&
                      set_from_bits(*row, entry.index, entry.value, &changed);
    if (!good) {
      event::table_refused({.entry = static_cast<std::uint32_t>(i),
                            .key = row == nullptr ? "unknown key" : row->key},
                           events);
      return "entry";
    }
  }
  table.begun = true;
  table.parameters = changed;
  table.crc = crc32_iso_hdlc(command.entry_octets(), table.crc);
  const auto entries = static_cast<std::uint32_t>(command.entries);
  table.entries += entries;
  event::table_loaded({.entries = entries, .in_all = table.entries}, events);
  return kDone;
}

/// Why the inactive table may not become active, or empty.
std::string_view objection(const bus::TableActivateCommand& commanded, const Configuration& c) {
  const InactiveTable& table = c.inactive;
  if (!table.begun) {
    return "no table loaded";
  }
  if (commanded.entries != table.entries || commanded.crc32 != table.crc) {
    return "count of entries or CRC differs";
  }
  if (const std::string_view key = first_bad_key(table.parameters); !key.empty()) {
    return key;
  }
  if (check(table.parameters)) {
    return "values that do not go together";
  }
  return needs_more_memory(table.parameters, c) ? "needs more memory" : "";
}

/// @return the reason of a refusal, or empty. Changed motion options drop the fitted model.
Outcome activate_table(const Command& command,
                       Configuration* configuration,
                       MotionEstimate* motion_estimate,
                       JobQueue* jobs,
                       bus::EventLog* events) {
  Configuration& c = *configuration;
  const std::string_view why = objection(command.arguments<bus::TableActivateCommand>(), c);
  if (!why.empty()) {
    event::table_not_activated({.reason = why}, events);
    return why;
  }
  // Length and range may have come by command since the table was begun.
  const ScaleOptions scale = c.parameters.scale;
  const MotionOptions motion = c.parameters.motion;
  c.parameters = c.inactive.parameters;
  c.parameters.scale = scale;
  if (c.parameters.motion != motion) {  // the poses are no longer taken to move as they were
    replace_model({}, motion_estimate);
    invalidate_fits(jobs);
  }
  c.inactive = {};
  c.table_crc = table_crc(c.parameters);
  event::table_activated({.crc = c.table_crc}, events);
  return kDone;
}

Outcome discard_table(InactiveTable* table) {
  if (!table->begun) {
    return "no table loaded";
  }
  *table = {};
  return kDone;
}

void reset_counters(Counters* counters, BusState* bus) {
  *counters = {};
  bus->reported.counters = {};
  bus->commands = {.last_code = bus->commands.last_code};  // this one
  bus->stream.not_sent = 0;
  bus->events.counts = {};
  bus->events.sent = 0;
  bus->events.suppressed = 0;
  event::counters_reset(&bus->events);
}

Outcome answer_point_question(const Command& command,
                              const Component::State& s,
                              bus::PointPacket* packet) {
  const auto asked = command.arguments<bus::PredictPointCommand>();
  PointState point;
  const std::string_view why = predict_point({.timestamp_ns = asked.predicted_timestamp_ns,
                                              .target_frame = asked.target_frame,
                                              .p_T = asked.p_T,
                                              .normal_T = asked.normal_T},
                                             s,
                                             &point);
  if (!why.empty()) {
    return why;
  }
  *packet = bus::to_packet(point);
  packet->number = asked.number;
  packet->target_frame = asked.target_frame;
  return kDone;
}

/// Commands that stop or reset the target change most rooms; the others get their own room only.
Outcome carry_out(const Command& command, Component::State* s) {
  Configuration* c = &s->configuration;
  bus::EventLog* events = &s->bus.events;
  Outcome outcome = kDone;
  bus::PointPacket point;
  switch (command.code) {
    case bus::CommandCode::kNoop:
      event::noop({.version = kVersion}, events);
      break;
    case bus::CommandCode::kResetCounters:
      reset_counters(&s->counters, &s->bus);
      break;
    case bus::CommandCode::kResetMap:
      reset_target(s);
      break;
    case bus::CommandCode::kHold:
      outcome = hold_frames(&s->mode);
      if (outcome == kDone) {
        pause(s);
      }
      break;
    case bus::CommandCode::kResume:
      return resume_frames(s->mapping.map, &s->mode);
    case bus::CommandCode::kSetKnownLength:
      return set_known_length(command, c, &s->scale);
    case bus::CommandCode::kSetRange:
      return set_range(command, c, &s->scale);
    case bus::CommandCode::kServicerAttitude:
      return take_attitude(command, &s->bus.servicer);
    case bus::CommandCode::kRequestCloud:
      return request_cloud(command, s->clock.timestamp_ns, s->mapping.map, s->scale, &s->bus);
    case bus::CommandCode::kPredictPoint:
      outcome = answer_point_question(command, *s, &point);
      if (outcome == kDone) {
        bus::append(point, c->parameters.bus, &s->bus.stream);
      }
      break;
    case bus::CommandCode::kTableLoad:
      return load_table(command, c, events);
    case bus::CommandCode::kTableActivate:
      return activate_table(command, c, &s->motion, &s->jobs, events);
    case bus::CommandCode::kTableDiscard:
      return discard_table(&c->inactive);
    case bus::CommandCode::kCheckpoint:
      s->answer.output.checkpoint_asked = true;
      event::checkpoint_asked({.frame = s->clock.frame}, events);
      break;
  }
  return outcome;
}

/// These commands have events of their own; an event of acceptance by name would repeat them.
bool answers_by_itself(bus::CommandCode code) {
  return code == bus::CommandCode::kNoop || code == bus::CommandCode::kResetCounters;
}

void reject(const Refusal& refusal, BusState* bus) {
  ++bus->commands.rejected;
  bus->commands.last_rejection = refusal.reason;
  bus::report_refusal(refusal, &bus->events);
}

/// Answered, but not carried out again, and in none of the counters of commands.
void answer_again(const Command& command, bus::EventLog* events) {
  event::command_repeated({.command = command.code,
                           .name = command.layout->name,
                           .sequence = bus::command_sequence(command.octets)},
                          events);
}

void execute(std::span<const std::uint8_t> octets, Component::State* s) {
  Command command;
  const Refusal refusal =
      bus::read_command(octets, s->configuration.parameters.bus.apid_first, &command);
  if (octets.size() >= bus::kCommandHeaderOctets) {
    s->bus.commands.last_code = bus::get_u8(octets, bus::kCommandHeaderOctets - 1);
  }
  if (refusal.reason != Rejection::kNone) {
    reject(refusal, &s->bus);
    return;
  }
  if (bus::was_done(octets, s->clock.timestamp_ns, s->bus.commands_done)) {
    answer_again(command, &s->bus.events);
    return;
  }
  const Outcome outcome = carry_out(command, s);
  if (outcome != kDone) {
    reject({.reason = Rejection::kState,
            .code = static_cast<std::uint8_t>(command.code),
            .why = outcome},
           &s->bus);
    return;
  }
  if (command.code != bus::CommandCode::kServicerAttitude) {  // refuses a repeated time by itself
    bus::remember(octets, s->clock.timestamp_ns, &s->bus.commands_done);
  }
  ++s->bus.commands.accepted;
  if (!answers_by_itself(command.code)) {
    event::command_accepted({.command = command.code, .name = command.layout->name},
                            &s->bus.events);
  }
}

}  // namespace

void execute_commands(std::span<const std::span<const std::uint8_t>> commands,
                      Component::State* s) {
  const std::size_t read = std::min(commands.size(), limits::kStepCommands);
  for (const std::span<const std::uint8_t> octets : commands.first(read)) {
    s->bus.events.command_sequence = bus::answered_sequence(octets);
    execute(octets, s);
  }
  s->bus.events.command_sequence = 0;
  if (commands.size() > read) {
    const auto beyond = static_cast<std::uint32_t>(commands.size() - read);
    reject({.reason = Rejection::kTooMany, .beyond = beyond}, &s->bus);
    s->bus.commands.rejected += beyond - 1;
  }
}

}  // namespace polhode
