#include "bus/report_changes.hpp"

#include <array>
#include <numbers>
#include <string_view>
#include <utility>

#include "bus/bus_state.hpp"
#include "bus/dynamics_telemetry.hpp"
#include "bus/frame_uses.hpp"
#include "bus/publish_motion.hpp"
#include "shape/scale_state.hpp"

namespace polhode::bus {
namespace {

// Two numbers of six digits with a sign and an exponent, and what is between them.
constexpr std::size_t kWordsOctetsMax = 64;

void tell(EventId id, double first, double second, BusState* bus) {
  report(id, {.values = {first, second}}, &bus->events);
}

void report_frame(const View& view, BusState* bus) {
  const double number = view.motion->frame;
  const FrameUseRow& row = row_of(view.use);
  if (row.has_event) {
    tell(row.event, number, static_cast<double>(view.verdict.measure), bus);
  } else if (view.verdict.decision == FrameDecision::kCare) {
    tell(EventId::kFrameWithCare, number, static_cast<double>(view.verdict.fault), bus);
  }
}

void report_mode(const View& view, BusState* bus) {
  const MotionState& motion = *view.motion;
  Reported& reported = bus->reported;
  if (motion.mode == reported.mode) {
    return;
  }
  tell(EventId::kModeChanged,
       static_cast<double>(reported.mode),
       static_cast<double>(motion.mode),
       bus);
  if (reported.mode == Mode::kAcquiring && motion.mode == Mode::kTracking) {
    tell(EventId::kTargetAcquired, motion.landmarks, motion.keyframes, bus);
  }
  const bool had_target = reported.mode == Mode::kTracking || reported.mode == Mode::kCoasting;
  if (had_target && motion.mode == Mode::kLost) {
    tell(EventId::kTargetLost, view.counters->poses, 0.0, bus);
  }
  if (motion.mode == Mode::kLost) {
    reported.frame_of_loss = motion.frame;
  }
  if (reported.mode == Mode::kLost && motion.mode == Mode::kTracking) {
    const double frames = motion.frame - reported.frame_of_loss;
    if (motion.target_frame != reported.target_frame) {
      tell(EventId::kTargetFrameNew, frames, motion.target_frame, bus);
    } else {
      tell(EventId::kTargetFoundAgain, frames, 0.0, bus);
    }
  }
}

/// What rates and predictions rest on. A frame without either changes nothing.
void report_motion(const View& view, BusState* bus) {
  const std::uint8_t now = dynamics_in_force(view);
  std::uint8_t& reported = bus->reported.dynamics;
  if (now == kDynamicsNone || now == reported) {
    return;
  }
  tell(EventId::kMotionChanged, reported, now, bus);
  reported = now;
}

/// Times that are not those of the pictures: said when it is found, and again after it was over.
void report_times(const View& view, BusState* bus) {
  // Chosen: five turns a second, several times what the fastest bodies in orbit are known to do.
  constexpr double kImplausible_deg_s = 1800.0;
  const MotionState& motion = *view.motion;
  if (!is_measured(motion)) {
    return;
  }
  Reported& reported = bus->reported;
  if (view.stamps.contradicted && !reported.stamps_doubted) {
    tell(EventId::kStampsDoubted, view.stamps.shortest_s, view.stamps.longest_s, bus);
  }
  reported.stamps_doubted = view.stamps.contradicted;
  const Eigen::Map<const Eigen::Vector3d> w_T(motion.w_T_rad_s.data());
  const double rate_deg_s = motion.rate_valid ? w_T.norm() * 180.0 / std::numbers::pi : 0.0;
  if (rate_deg_s > kImplausible_deg_s && !reported.rate_implausible) {
    tell(EventId::kRateImplausible, rate_deg_s, 0.0, bus);
  }
  reported.rate_implausible = rate_deg_s > kImplausible_deg_s;
}

/// Said when a test contradicts what was stated, and again after it was borne out. A principal
/// point is one statement of two numbers; all others are told with their sigma.
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
      report(EventId::kFocalLengthDoubted,
             {.values = {is.stated, is.fits}, .word = std::string_view(words.data(), octets)},
             &bus->events);
      continue;
    }
    const bool is_point = deviation == Deviation::kPrincipalU;
    const double second =
        is_point ? describe(Deviation::kPrincipalV, found, *camera.stated).fits : is.sigma;
    const std::size_t octets =
        event_text(is_point ? "{}" : "{} and sigma", {.word = is.name}, words);
    report(EventId::kCameraContradicted,
           {.values = {is.fits, second}, .word = std::string_view(words.data(), octets)},
           &bus->events);
  }
}

/// What the scale was, and what it is. That a first map has a unit of its own is no news.
void report_scale(const ScaleState& scale, BusState* bus) {
  const ScaleNumber before = bus->reported.scale;
  const double number = bus->scale.number;
  if (scale.not_improved > bus->reported.scale_not_improved) {
    tell(EventId::kScaleNotImproved, scale.relative_sigma, scale.keyframes_at_reading, bus);
  }
  bus->reported.scale_not_improved = scale.not_improved;
  bus->reported.scale = bus->scale;
  if (bus->scale.number == before.number || !(scale.known || before.unit.known)) {
    return;
  }
  if (!scale.known) {
    tell(EventId::kScaleUnknown, before.unit.metres_per_mu, number, bus);
    return;
  }
  std::array<char, kWordsOctetsMax> words{};
  const std::string_view pattern =
      before.unit.known ? "number {0}, before: {1}" : "number {0}, before: map units";
  const std::size_t octets =
      event_text(pattern, {.values = {number, before.unit.metres_per_mu}}, words);
  report(EventId::kScaleKnown,
         {.values = {scale.metres_per_mu, scale.relative_sigma},
          .word = std::string_view(words.data(), octets)},
         &bus->events);
}

}  // namespace

void report_changes(const View& view, BusState* bus) {
  Reported& reported = bus->reported;
  const MotionState& motion = *view.motion;
  const ScaleState& scale = *view.scale;
  if (!reported.started) {
    report(EventId::kStarted,
           {.values = {static_cast<double>(view.table.crc), 0.0}, .word = view.version},
           &bus->events);
  }
  report_frame(view, bus);
  report_mode(view, bus);
  report_motion(view, bus);
  report_times(view, bus);
  report_camera(view.camera, bus);
  const Counters& now = *view.counters;
  if (now.closures != reported.counters.closures) {
    tell(EventId::kLoopClosed, now.closures - reported.counters.closures, 0.0, bus);
  }
  if (now.tables_full != reported.counters.tables_full) {
    tell(EventId::kTableFull, now.tables_full - reported.counters.tables_full, 0.0, bus);
  }
  report_scale(scale, bus);
  reported.started = true;
  reported.counters = now;
  reported.mode = motion.mode;
  // A map may begin and be lost within a step: nobody has heard of its frame then.
  reported.target_frame =
      motion.mode == Mode::kTracking ? motion.target_frame : reported.target_frame;
}

}  // namespace polhode::bus
