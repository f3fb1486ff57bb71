// Where a point of the target will be: the question of a planner, by call or by command.
#pragma once

#include <string_view>

#include "pipeline/component.hpp"

namespace polhode {

/// By what the last step left, in the unit of lengths that is published.
/// @return empty, or why there is no answer; then `answer` is untouched.
[[nodiscard]] std::string_view predict_point(const PointQuestion& question,
                                             const Component::State& state,
                                             PointState* answer);

}  // namespace polhode
