#include "pipeline/modes.hpp"

namespace polhode {
namespace {

/// Modes that a transition starts from, as bits.
enum From : std::uint8_t {
  kFromIdle = 1,
  kFromAcquiring = 2,
  kFromTracking = 4,
  kFromLost = 8,
  kFromCoasting = 16
};
constexpr std::uint8_t kFromAny =
    kFromIdle | kFromAcquiring | kFromTracking | kFromLost | kFromCoasting;
constexpr std::uint8_t kFromMapped = kFromTracking | kFromLost | kFromCoasting;

enum class When : std::uint8_t { kAlways, kHeld, kNotHeld };

struct Transition {
  ModeEvent event;
  std::uint8_t from;
  When when;
  Mode to;
};

constexpr Transition kTransitions[] = {
    {ModeEvent::kHoldCommanded, kFromAny, When::kAlways, Mode::kIdle},
    {ModeEvent::kResumedWithMap, kFromAny, When::kNotHeld, Mode::kLost},
    {ModeEvent::kResumedWithoutMap, kFromAny, When::kNotHeld, Mode::kAcquiring},
    {ModeEvent::kFrameComes, kFromAny, When::kHeld, Mode::kIdle},
    {ModeEvent::kFrameComes, kFromIdle, When::kNotHeld, Mode::kAcquiring},
    {ModeEvent::kMapBegun, kFromAcquiring | kFromLost, When::kNotHeld, Mode::kTracking},
    {ModeEvent::kPoseFound, kFromMapped, When::kNotHeld, Mode::kTracking},
    {ModeEvent::kPoseNotFound, kFromMapped, When::kNotHeld, Mode::kLost},
    {ModeEvent::kPosePredicted, kFromTracking | kFromCoasting, When::kNotHeld, Mode::kCoasting},
    {ModeEvent::kTargetReset, kFromAny, When::kNotHeld, Mode::kAcquiring},
    {ModeEvent::kWarmStartWithMap, kFromAny, When::kAlways, Mode::kLost},
    {ModeEvent::kWarmStartWithoutMap, kFromAny, When::kAlways, Mode::kIdle},
};

}  // namespace

void change_mode(ModeEvent event, ModeState* mode) {
  for (const Transition& t : kTransitions) {
    const bool from_here = (t.from >> static_cast<unsigned>(mode->now) & 1U) != 0;
    const bool now = t.when == When::kAlways || (t.when == When::kHeld) == mode->held;
    if (t.event == event && from_here && now) {
      mode->now = t.to;
      return;
    }
  }
}

}  // namespace polhode
