#include "bus/report_changes.hpp"

#include <array>
#include <numbers>
#include <string_view>
#include <utility>

#include "bus/bus_state.hpp"
#include "bus/dynamics_telemetry.hpp"
#include "bus/event_reports.hpp"
#include "bus/publish_motion.hpp"
#include "shape/scale_state.hpp"

namespace polhode::bus {
namespace {

// Two numbers of six digits with a sign and an exponent, and the text between them.
constexpr std::size_t kWordsOctetsMax = 64;

void report_mode(const View& view, BusState* bus) {
  const MotionState& motion = *view.motion;
  Reported& reported = bus->reported;
  if (motion.mode == reported.mode) {
    return;
  }
  EventLog* log = &bus->events;
  event::mode_changed({.before = reported.mode, .now = motion.mode}, log);
  if (reported.mode == Mode::kAcquiring && motion.mode == Mode::kTracking) {
    event::target_acquired({.landmarks = motion.landmarks, .keyframes = motion.keyframes}, log);
  }
  const bool had_target = reported.mode == Mode::kTracking || reported.mode == Mode::kCoasting;
  if (had_target && motion.mode == Mode::kLost) {
    event::target_lost({.poses = view.counters->poses}, log);
  }
  if (motion.mode == Mode::kLost) {
    reported.frame_of_loss = motion.frame;
  }
  if (reported.mode == Mode::kLost && motion.mode == Mode::kTracking) {
    const std::uint32_t frames = motion.frame - reported.frame_of_loss;
    if (motion.target_frame != reported.target_frame) {
      event::target_frame_new({.frames = frames, .target_frame = motion.target_frame}, log);
    } else {
      event::target_found_again({.frames = frames}, log);
    }
  }
}

/// Reports a change of the model behind rates and predictions. A frame without either is skipped.
void report_motion(const View& view, BusState* bus) {
  const std::uint8_t now = dynamics_in_force(view);
  std::uint8_t& reported = bus->reported.dynamics;
  if (now == kDynamicsNone || now == reported) {
    return;
  }
  event::motion_changed({.before = reported, .now = now}, &bus->events);
  reported = now;
}

/// Reports contradicted time stamps and implausible rates, each once until it has ended.
void report_times(const View& view, BusState* bus) {
  // Chosen: five turns a second, several times what the fastest bodies in orbit are known to do.
  constexpr double kImplausible_deg_s = 1800.0;
  const MotionState& motion = *view.motion;
  if (!is_measured(motion)) {
    return;
  }
  Reported& reported = bus->reported;
  if (view.stamps.contradicted && !reported.stamps_doubted) {
    event::stamps_doubted(
        {.shortest_s = view.stamps.shortest_s, .longest_s = view.stamps.longest_s}, &bus->events);
  }
  reported.stamps_doubted = view.stamps.contradicted;
  const Eigen::Map<const Eigen::Vector3d> w_T(motion.w_T_rad_s.data());
  const double rate_deg_s = motion.rate_valid ? w_T.norm() * 180.0 / std::numbers::pi : 0.0;
  if (rate_deg_s > kImplausible_deg_s && !reported.rate_implausible) {
    event::rate_implausible({.rate_deg_s = rate_deg_s}, &bus->events);
  }
  reported.rate_implausible = rate_deg_s > kImplausible_deg_s;
}

/// Reports a contradiction of the stated camera once, and again only after a consistent test. The
/// principal point is one event with two coordinates; all others have a sigma.
void report_camera(const CameraDoubt& camera, BusState* bus) {
  const CameraFinding& found = *camera.found;
  const auto before = std::exchange(bus->reported.contradicted, found.contradicted);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto deviation = static_cast<Deviation>(i);
    if (!found.is(deviation) || before[i] != 0 || deviation == Deviation::kPrincipalV) {
      continue;
    }
    const DeviationText is = describe(deviation, found, *camera.stated);
    std::array<char, kWordsOctetsMax> words{};
    if (deviation == Deviation::kFocal) {
      const std::size_t octets =
          event_text("relative sigma {0}", {.values = {is.sigma / is.fits}}, words);
      event::focal_length_doubted(
          {.stated_px = is.stated, .fits_px = is.fits, .sigma = {words.data(), octets}},
          &bus->events);
      continue;
    }
    const bool is_point = deviation == Deviation::kPrincipalU;
    const double second =
        is_point ? describe(Deviation::kPrincipalV, found, *camera.stated).fits : is.sigma;
    const std::size_t octets =
        event_text(is_point ? "{}" : "{} and sigma", {.word = is.name}, words);
    event::camera_contradicted(
        {.quantity = {words.data(), octets}, .fits = is.fits, .sigma_or_v = second}, &bus->events);
  }
}

/// Reports a new scale, with the one before. A first map's own unit is not reported.
void report_scale(const ScaleState& scale, BusState* bus) {
  const ScaleNumber before = bus->reported.scale;
  const std::uint32_t number = bus->scale.number;
  if (scale.not_improved > bus->reported.scale_not_improved) {
    event::scale_not_improved({.relative_sigma = scale.relative_sigma,
                               .keyframes = static_cast<std::uint32_t>(scale.keyframes_at_reading)},
                              &bus->events);
  }
  bus->reported.scale_not_improved = scale.not_improved;
  bus->reported.scale = bus->scale;
  if (bus->scale.number == before.number || !(scale.known || before.unit.known)) {
    return;
  }
  if (!scale.known) {
    event::scale_unknown({.metres_per_mu = before.unit.metres_per_mu, .number = number},
                         &bus->events);
    return;
  }
  std::array<char, kWordsOctetsMax> words{};
  const std::string_view pattern =
      before.unit.known ? "number {0}, before: {1}" : "number {0}, before: map units";
  const std::size_t octets = event_text(
      pattern, {.values = {static_cast<double>(number), before.unit.metres_per_mu}}, words);
  event::scale_known({.metres_per_mu = scale.metres_per_mu,
                      .relative_sigma = scale.relative_sigma,
                      .number = {words.data(), octets}},
                     &bus->events);
}

}  // namespace

void report_frame(std::uint32_t frame, FrameUse use, const FrameVerdict& verdict, EventLog* log) {
  const auto measure = static_cast<double>(verdict.measure);
  switch (use) {
    case FrameUse::kUnreadable:
      return event::frame_unreadable({.frame = frame}, log);
    case FrameUse::kWrongSize:
      return event::frame_wrong_size({.frame = frame}, log);
    case FrameUse::kTimeNotIncreasing:
      return event::frame_time_not_increasing({.frame = frame}, log);
    case FrameUse::kDark:
      return event::frame_dark({.frame = frame, .bright_level = measure}, log);
    case FrameUse::kFlat:
      return event::frame_flat({.frame = frame, .contrast = measure}, log);
    case FrameUse::kSaturated:
      return event::frame_saturated({.frame = frame, .fraction = measure}, log);
    case FrameUse::kFrozen:
      return event::frame_frozen({.frame = frame, .repeated_rows = measure}, log);
    case FrameUse::kTorn:
      return event::frame_torn({.frame = frame, .repeated_rows = measure}, log);
    case FrameUse::kBitErrors:
      return event::frame_bit_errors({.frame = frame, .traces = measure}, log);
    case FrameUse::kUsed:
    case FrameUse::kHeld:
      break;
  }
  if (verdict.decision == FrameDecision::kCare) {
    event::frame_with_care({.frame = frame, .fault = verdict.fault}, log);
  }
}

void report_changes(const View& view, BusState* bus) {
  Reported& reported = bus->reported;
  const MotionState& motion = *view.motion;
  const ScaleState& scale = *view.scale;
  if (!reported.started) {
    event::started({.version = view.version, .table_crc = view.table.crc}, &bus->events);
  }
  report_frame(motion.frame, view.use, view.verdict, &bus->events);
  report_mode(view, bus);
  report_motion(view, bus);
  report_times(view, bus);
  report_camera(view.camera, bus);
  const Counters& now = *view.counters;
  if (now.closures != reported.counters.closures) {
    event::loop_closed({.loops = now.closures - reported.counters.closures}, &bus->events);
  }
  if (now.tables_full != reported.counters.tables_full) {
    event::table_full({.times = now.tables_full - reported.counters.tables_full}, &bus->events);
  }
  report_scale(scale, bus);
  reported.started = true;
  reported.counters = now;
  reported.mode = motion.mode;
  // A map may begin and be lost within a step: its frame has not been reported then.
  reported.target_frame =
      motion.mode == Mode::kTracking ? motion.target_frame : reported.target_frame;
}

}  // namespace polhode::bus
