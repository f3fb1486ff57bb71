// std::clamp by value: the references of std::clamp keep a loop from being vectorised.
#pragma once

namespace polhode {

/// @pre low <= high. NaN stays NaN.
constexpr float limited(float value, float low, float high) {
  const float raised = value < low ? low : value;
  return raised > high ? high : raised;
}

}  // namespace polhode
