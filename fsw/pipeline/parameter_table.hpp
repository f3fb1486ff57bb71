// One row per parameter: its name, its member, its allowed values. The check before start, the
// reader of configuration files, the printed table and config/default.toml all come from these
// rows.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "base/result.hpp"
#include "pipeline/parameters.hpp"

namespace polhode {

using PointPair = std::array<std::array<double, 2>, 2>;

template <typename T>
using Member = T& (*)(Parameters&);

using AnyMember = std::variant<Member<bool>,
                               Member<int>,
                               Member<std::int64_t>,
                               Member<std::uint64_t>,
                               Member<double>,
                               Member<MotionMode>,
                               Member<DynamicsKind>,
                               Member<PointPair>>;

/// The words that a choice is written in, in the order of its values.
inline constexpr std::array<std::string_view, 2> choices_of(MotionMode /*which*/) {
  return {"dynamics", "paper"};
}
inline constexpr std::array<std::string_view, 2> choices_of(DynamicsKind /*which*/) {
  return {"torque_free", "orbit"};
}

struct ParameterRow {
  std::string_view key;  ///< dotted, as in a configuration file: "features.count_max"
  AnyMember member;      ///< where the value is
  double low = 0.0;      ///< least and greatest allowed value, both allowed
  double high = 0.0;
  std::string_view unit;  ///< empty: a count, a ratio or a switch
  std::string_view help;  ///< one line: what it does
};

/// The members are reached through a mutable reference only; a reader writes nothing.
inline Parameters& readable(const Parameters& parameters) {
  return const_cast<Parameters&>(parameters);
}

/// All parameters, in the order of the sections.
std::span<const ParameterRow> parameter_table();

/// @return the row of this dotted key, or nullptr.
const ParameterRow* find_parameter(std::string_view key);

/// True for keys without a default: they are absent unless configured (`camera.*`, `scale.*`).
bool has_no_default(std::string_view key);

/// The value as text that reads back to the same value.
std::string value_text(const ParameterRow& row, const Parameters& parameters);

/// The allowed values as text, "50 .. 1000".
std::string range_text(const ParameterRow& row);

/// @return the problem with this one value, if it is out of range.
std::optional<Error> check_row(const ParameterRow& row, const Parameters& parameters);

/// As check(), without the camera: a configuration may leave it to the sequence's sensor.yaml.
std::optional<Error> check_without_camera(const Parameters& parameters);

}  // namespace polhode
