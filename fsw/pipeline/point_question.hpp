// Predicts a point of the target for a planner, by call or by command.
#pragma once

#include <string_view>

#include "pipeline/component.hpp"

namespace polhode {

/// Predicts from the state after the last step, in the published unit of lengths.
/// @return empty, or the reason why there is no answer; then `answer` is untouched.
[[nodiscard]] std::string_view predict_point(const PointQuestion& question,
                                             const Component::State& state,
                                             PointState* answer);

}  // namespace polhode
