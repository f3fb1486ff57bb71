// As std::clamp, by value: a loop that calls it is compiled for many places at once, which
// references prevent.
#pragma once

namespace polhode {

/// @pre low <= high. Not a number stays that.
constexpr float limited(float value, float low, float high) {
  const float raised = value < low ? low : value;
  return raised > high ? high : raised;
}

}  // namespace polhode
