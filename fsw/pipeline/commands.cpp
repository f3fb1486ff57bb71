#include "pipeline/commands.hpp"

#include <algorithm>

#include "base/crc.hpp"
#include "base/earlier_times.hpp"
#include "base/validity.hpp"
#include "bus/commands.hpp"
#include "bus/dynamics_telemetry.hpp"
#include "motion/disturbance.hpp"
#include "pipeline/parameter_image.hpp"
#include "pipeline/point_question.hpp"
#include "pipeline/reset.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

using bus::Command;
using bus::EventId;
using bus::Refusal;
using bus::Rejection;

/// What a command that is right in itself came to: done, or refused in this state and why.
using Outcome = std::string_view;
constexpr Outcome kDone{};

Outcome command_hold(Component::State* s) {
  if (s->mode.held) {
    return "held already";
  }
  s->mode.held = true;
  change_mode(ModeEvent::kHoldCommanded, &s->mode);
  pause(s);
  return kDone;
}

Outcome resume(Component::State* s) {
  if (!s->mode.held) {
    return "not held";
  }
  s->mode.held = false;
  const bool has_map = s->mapping.map.landmark_count > 0;
  change_mode(has_map ? ModeEvent::kResumedWithMap : ModeEvent::kResumedWithoutMap, &s->mode);
  return kDone;
}

/// Length and range share the frame that they are read in, so each replaces the other, once it can
/// be read.
Outcome scale_read_in(std::int64_t frame_timestamp_ns, Component::State* s) {
  s->configuration.parameters.scale.frame_timestamp_ns = frame_timestamp_ns;
  s->configuration.table_crc = table_crc(s->configuration.parameters);
  s->scale.keyframes_at_reading = 0;
  return kDone;
}

Outcome set_known_length(const Command& command, Component::State* s) {
  const auto length = command.arguments<bus::SetKnownLengthCommand>();
  const auto inside = [&](const std::array<double, 2>& px) {
    return px[0] <= s->configuration.camera.width_px - 0.5 &&
           px[1] <= s->configuration.camera.height_px - 0.5;
  };
  if (!inside(length.first_px) || !inside(length.second_px)) {
    return "point outside the image";
  }
  ScaleOptions& scale = s->configuration.parameters.scale;
  scale.known_length_m = length.length_m;
  scale.points_px = {length.first_px, length.second_px};
  scale.range_m = 0.0;
  return scale_read_in(length.frame_timestamp_ns, s);
}

Outcome set_range(const Command& command, Component::State* s) {
  const auto range = command.arguments<bus::SetRangeCommand>();
  s->configuration.parameters.scale.range_m = range.range_m;
  s->configuration.parameters.scale.known_length_m = 0.0;
  return scale_read_in(range.frame_timestamp_ns, s);
}

Outcome servicer_attitude(const Command& command, Component::State* s) {
  const auto told = command.arguments<bus::ServicerAttitudeCommand>();
  ServicerAttitude& servicer = s->bus.servicer;
  if (!validity::is_time(told.timestamp_ns)) {
    return "time is beyond the year 2116";
  }
  if (servicer.known && told.timestamp_ns <= servicer.timestamp_ns &&
      !outvotes(told.timestamp_ns, &servicer.doubt)) {
    return "time does not increase";
  }
  servicer = {
      .known = true,
      .timestamp_ns = told.timestamp_ns,
      .q_IC =
          Eigen::Quaterniond(told.q_IC[0], told.q_IC[1], told.q_IC[2], told.q_IC[3]).normalized(),
      .w_C_rad_s = {told.w_C_rad_s[0], told.w_C_rad_s[1], told.w_C_rad_s[2]}};
  return kDone;
}

Outcome request_cloud(const Command& command, Component::State* s) {
  const auto request = command.arguments<bus::RequestCloudCommand>();
  const auto in_map = static_cast<std::size_t>(s->mapping.map.landmark_count);
  if (in_map == 0) {
    return "no map";
  }
  CloudRequest& cloud = s->bus.cloud;
  cloud.points_T.clear();
  cloud.next = 0;
  ++cloud.number;
  cloud.timestamp_ns = s->clock.timestamp_ns;
  cloud.scale_known = s->scale.known;
  cloud.metres_per_mu = s->scale.metres_per_mu;
  const std::size_t wanted = std::min<std::size_t>(request.points_max, in_map);
  std::size_t seen = 0;
  for (const Landmark& landmark : s->mapping.map.landmarks) {
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
  const auto packets = static_cast<double>(chunks_of(cloud.points_T.size()));
  bus::report(EventId::kCloudBegun,
              {.values = {static_cast<double>(cloud.points_T.size()), packets}},
              &s->bus.events);
  return kDone;
}

Outcome table_load(const Command& command, Component::State* s) {
  Configuration& c = s->configuration;
  InactiveTable& table = c.inactive;
  Parameters changed = table.begun ? table.parameters : c.parameters;
  for (std::size_t i = 0; i < command.entries; ++i) {
    const bus::TableLoadEntry entry = command.entry(i);
    const ParameterRow* row = find_parameter_by_crc(entry.key_crc);
    const bool good = row != nullptr && may_change_in_flight(row->key) &&
                      set_from_bits(*row, entry.index, entry.value, &changed);
    if (!good) {
      bus::report(EventId::kTableRefused,
                  {.values = {static_cast<double>(i), 0.0},
                   .word = row == nullptr ? std::string_view("unknown key") : row->key},
                  &s->bus.events);
      return "entry";
    }
  }
  table.begun = true;
  table.parameters = changed;
  table.crc = crc32_iso_hdlc(command.entry_octets(), table.crc);
  table.entries += static_cast<std::uint32_t>(command.entries);
  bus::report(
      EventId::kTableLoaded,
      {.values = {static_cast<double>(command.entries), static_cast<double>(table.entries)}},
      &s->bus.events);
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

Outcome table_activate(const Command& command, Component::State* s) {
  Configuration& c = s->configuration;
  const std::string_view why = objection(command.arguments<bus::TableActivateCommand>(), c);
  if (!why.empty()) {
    bus::report(EventId::kTableNotActivated, {.word = why}, &s->bus.events);
    return why;
  }
  // Length and range may have come by command since the table was begun.
  const ScaleOptions scale = c.parameters.scale;
  const MotionOptions motion = c.parameters.motion;
  c.parameters = c.inactive.parameters;
  c.parameters.scale = scale;
  if (c.parameters.motion != motion) {  // the poses are no longer taken to move as they were
    replace_model({}, &s->motion);
    invalidate_fits(&s->jobs);
  }
  c.inactive = {};
  c.table_crc = table_crc(c.parameters);
  bus::report(EventId::kTableActivated,
              {.values = {static_cast<double>(c.table_crc), 0.0}},
              &s->bus.events);
  return kDone;
}

Outcome table_discard(Component::State* s) {
  if (!s->configuration.inactive.begun) {
    return "no table loaded";
  }
  s->configuration.inactive = {};
  return kDone;
}

Outcome noop(Component::State* s) {
  bus::report(EventId::kNoop, {.word = kVersion}, &s->bus.events);
  return kDone;
}

Outcome reset_counters(Component::State* s) {
  s->counters = {};
  s->bus.reported.counters = {};
  s->bus.commands = {.last_code = s->bus.commands.last_code};  // this one
  s->bus.stream.not_sent = 0;
  s->bus.events.counts = {};
  s->bus.events.sent = 0;
  s->bus.events.suppressed = 0;
  bus::report(EventId::kCountersReset, {}, &s->bus.events);
  return kDone;
}

Outcome checkpoint(Component::State* s) {
  s->answer.output.checkpoint_asked = true;
  bus::report(EventId::kCheckpointAsked,
              {.values = {static_cast<double>(s->clock.frame), 0.0}},
              &s->bus.events);
  return kDone;
}

Outcome reset_map(Component::State* s) {
  reset_target(s);
  return kDone;
}

Outcome predict_point(const Command& command,
                      const Component::State& s,
                      bus::PacketStream* stream) {
  const auto asked = command.arguments<bus::PredictPointCommand>();
  PointState point;
  const std::string_view why = polhode::predict_point({.timestamp_ns = asked.predicted_timestamp_ns,
                                                       .target_frame = asked.target_frame,
                                                       .p_T = asked.p_T,
                                                       .normal_T = asked.normal_T},
                                                      s,
                                                      &point);
  if (!why.empty()) {
    return why;
  }
  bus::PointPacket packet = bus::to_packet(point);
  packet.number = asked.number;
  packet.target_frame = asked.target_frame;
  bus::append(packet, s.configuration.parameters.bus, stream);
  return kDone;
}

Outcome carry_out(const Command& command, Component::State* s) {
  switch (command.code) {
    case bus::CommandCode::kNoop:
      return noop(s);
    case bus::CommandCode::kResetCounters:
      return reset_counters(s);
    case bus::CommandCode::kResetMap:
      return reset_map(s);
    case bus::CommandCode::kHold:
      return command_hold(s);
    case bus::CommandCode::kResume:
      return resume(s);
    case bus::CommandCode::kSetKnownLength:
      return set_known_length(command, s);
    case bus::CommandCode::kSetRange:
      return set_range(command, s);
    case bus::CommandCode::kServicerAttitude:
      return servicer_attitude(command, s);
    case bus::CommandCode::kRequestCloud:
      return request_cloud(command, s);
    case bus::CommandCode::kPredictPoint:
      return predict_point(command, *s, &s->bus.stream);
    case bus::CommandCode::kTableLoad:
      return table_load(command, s);
    case bus::CommandCode::kTableActivate:
      return table_activate(command, s);
    case bus::CommandCode::kTableDiscard:
      return table_discard(s);
    case bus::CommandCode::kCheckpoint:
      return checkpoint(s);
  }
  return "unknown";
}

/// Events of their own answer these: an acceptance by name would say it twice.
bool answers_by_itself(bus::CommandCode code) {
  return code == bus::CommandCode::kNoop || code == bus::CommandCode::kResetCounters;
}

void reject(Rejection reason, const bus::EventDetails& details, Component::State* s) {
  ++s->bus.commands.rejected;
  s->bus.commands.last_rejection = reason;
  bus::report(bus::event_of(reason), details, &s->bus.events);
}

/// Answered, but not carried out again, and in none of the counters of commands.
void answer_again(const Command& command, Component::State* s) {
  bus::report(EventId::kCommandRepeated,
              {.values = {static_cast<double>(command.code),
                          static_cast<double>(bus::command_sequence(command.octets))},
               .word = command.layout->name},
              &s->bus.events);
}

void execute(std::span<const std::uint8_t> octets, Component::State* s) {
  Command command;
  const Refusal refusal =
      bus::read_command(octets, s->configuration.parameters.bus.apid_first, &command);
  if (octets.size() >= bus::kCommandHeaderOctets) {
    s->bus.commands.last_code = bus::get_u8(octets, bus::kCommandHeaderOctets - 1);
  }
  if (refusal.reason != Rejection::kNone) {
    reject(refusal.reason, refusal.details, s);
    return;
  }
  if (bus::was_done(octets, s->clock.timestamp_ns, s->bus.commands_done)) {
    answer_again(command, s);
    return;
  }
  const double code = static_cast<double>(command.code);
  const Outcome outcome = carry_out(command, s);
  if (outcome != kDone) {
    reject(Rejection::kState, {.values = {code, 0.0}, .word = outcome}, s);
    return;
  }
  if (command.code != bus::CommandCode::kServicerAttitude) {  // refuses a repeated time by itself
    bus::remember(octets, s->clock.timestamp_ns, &s->bus.commands_done);
  }
  ++s->bus.commands.accepted;
  if (!answers_by_itself(command.code)) {
    bus::report(EventId::kCommandAccepted,
                {.values = {code, 0.0}, .word = command.layout->name},
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
    const std::size_t beyond = commands.size() - read;
    reject(Rejection::kTooMany,
           {.values = {static_cast<double>(beyond), static_cast<double>(limits::kStepCommands)}},
           s);
    s->bus.commands.rejected += static_cast<std::uint32_t>(beyond - 1);
  }
}

}  // namespace polhode
