#include "pipeline/tell_events.hpp"

#include "pipeline/frame_uses.hpp"

namespace polhode {
namespace {

using bus::EventId;

void tell(EventId id, double first, double second, Component::State* s) {
  bus::report(id, {.values = {first, second}}, &s->bus.events);
}

void tell_frame(FrameUse use, std::uint32_t frame, Component::State* s) {
  const double number = frame;
  const FrameUseRow& row = row_of(use);
  if (row.has_event) {
    tell(row.event, number, static_cast<double>(s->verdict.measure), s);
  } else if (s->verdict.decision == FrameDecision::kCare) {
    tell(EventId::kFrameWithCare, number, static_cast<double>(s->verdict.fault), s);
  }
}

void tell_mode(const MotionState& motion, Component::State* s) {
  const ToldSoFar& told = s->bus.told;
  if (motion.mode == told.mode) {
    return;
  }
  tell(EventId::kModeChanged, static_cast<double>(told.mode), static_cast<double>(motion.mode), s);
  if (told.mode == Mode::kAcquiring && motion.mode == Mode::kTracking) {
    tell(EventId::kTargetAcquired, motion.landmarks, motion.keyframes, s);
  }
  if (told.mode == Mode::kTracking && motion.mode == Mode::kLost) {
    tell(EventId::kTargetLost, s->counters.poses, 0.0, s);
  }
  if (motion.mode == Mode::kLost) {
    s->bus.told.frame_of_loss = motion.frame;
  }
  if (told.mode == Mode::kLost && motion.mode == Mode::kTracking) {
    const double frames = motion.frame - told.frame_of_loss;
    if (s->target_frame != told.target_frame) {
      tell(EventId::kTargetFrameNew, frames, s->target_frame, s);
    } else {
      tell(EventId::kTargetFoundAgain, frames, 0.0, s);
    }
  }
}

}  // namespace

void tell_events(FrameUse use, const MotionState& motion, Component::State* s) {
  ToldSoFar& told = s->bus.told;
  if (!told.started) {
    bus::report(EventId::kStarted,
                {.values = {static_cast<double>(s->bus.table_crc), 0.0}, .word = kVersion},
                &s->bus.events);
  }
  tell_frame(use, motion.frame, s);
  tell_mode(motion, s);
  const Counters& now = s->counters;
  if (now.closures != told.counters.closures) {
    tell(EventId::kLoopClosed, now.closures - told.counters.closures, 0.0, s);
  }
  if (now.tables_full != told.counters.tables_full) {
    tell(EventId::kTableFull, now.tables_full - told.counters.tables_full, 0.0, s);
  }
  if (s->scale.known && told.metres_per_mu != s->scale.metres_per_mu) {
    tell(EventId::kScaleKnown, s->scale.metres_per_mu, s->scale.relative_sigma, s);
  }
  told.started = true;
  told.counters = now;
  told.mode = motion.mode;
  // A map may begin and be lost within a step: nobody has heard of its frame then.
  told.target_frame = motion.mode == Mode::kTracking ? s->target_frame : told.target_frame;
  told.metres_per_mu = s->scale.known ? s->scale.metres_per_mu : 0.0;
}

}  // namespace polhode
