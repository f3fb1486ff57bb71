// Parameters of the C interface: the rows of parameter_table.cpp by their keys.
#include "capi/parameters.hpp"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <new>
#include <string>
#include <type_traits>
#include <variant>

#include "capi/problem.hpp"
#include "pipeline/parameter_image.hpp"
#include "pipeline/parameter_table.hpp"

namespace {

using polhode::ParameterRow;
using polhode::capi::guarded;
using polhode::capi::write_problem;

static_assert(std::is_trivially_destructible_v<polhode_parameters>, "the header promises no end");
static_assert(alignof(polhode_parameters) <= alignof(std::max_align_t), "as malloc aligns");

bool is_real(const ParameterRow& row) {
  return std::holds_alternative<polhode::Member<double>>(row.member) ||
         std::holds_alternative<polhode::Member<polhode::PointPair>>(row.member);
}

/// A number as the shortest text that reads back to it.
template <typename Number>
std::string text_of(Number value) {
  std::array<char, 32> text{};  // the longest binary64 has 24 characters
  return {text.data(), std::to_chars(text.begin(), text.end(), value).ptr};
}

/// Of a value.
struct Place {
  polhode_parameters* parameters = nullptr;
  const char* key = nullptr;
  std::size_t index = 0;
};

/// @param bits  of a binary64 where the row is one, else a two's complement whole number
template <typename Number>
polhode_status set_bits(const Place& place,
                        std::uint64_t (*bits_for)(const ParameterRow&, Number, bool*),
                        Number value,
                        char* problem,
                        std::size_t problem_octets) {
  return guarded([&] {
    const auto& [parameters, key, index] = place;
    if (parameters == nullptr || key == nullptr) {
      write_problem("parameters or key: null", problem, problem_octets);
      return polhode_status{POLHODE_BAD_ARGUMENT};
    }
    const ParameterRow* row = polhode::find_parameter(key);
    if (row == nullptr || index >= polhode::value_count(*row)) {
      write_problem(
          std::string(key) + (row == nullptr ? ": no such parameter" : ": index out of range"),
          problem,
          problem_octets);
      return polhode_status{POLHODE_BAD_ARGUMENT};
    }
    bool exact = true;
    const std::uint64_t bits = bits_for(*row, value, &exact);
    if (!exact || !polhode::set_from_bits(*row, index, bits, &parameters->values)) {
      write_problem(std::string(key) + " = " + text_of(value) + ": allowed is " +
                        (is_real(*row) ? "" : "a whole number in ") + polhode::range_text(*row),
                    problem,
                    problem_octets);
      return polhode_status{POLHODE_BAD_PARAMETER};
    }
    return polhode_status{POLHODE_OK};
  });
}

std::uint64_t bits_of_real(const ParameterRow& row, double value, bool* exact) {
  if (is_real(row)) {
    return std::bit_cast<std::uint64_t>(value);
  }
  constexpr double kWholeMax =
      9007199254740992.0;  // 2^53: up to here doubles name each whole number
  *exact = std::isfinite(value) && std::fabs(value) <= kWholeMax && std::trunc(value) == value;
  return *exact ? static_cast<std::uint64_t>(static_cast<std::int64_t>(value)) : 0;
}

std::uint64_t bits_of_whole(const ParameterRow& row, std::int64_t value, bool* exact) {
  *exact = true;
  return is_real(row) ? std::bit_cast<std::uint64_t>(static_cast<double>(value))
                      : static_cast<std::uint64_t>(value);
}

}  // namespace

size_t polhode_parameters_octets(void) { return sizeof(polhode_parameters); }

polhode_status polhode_parameters_create(void* memory, size_t bytes, polhode_parameters** out) {
  if (memory == nullptr || out == nullptr) {
    return POLHODE_BAD_ARGUMENT;
  }
  const bool aligned = reinterpret_cast<std::uintptr_t>(memory) % alignof(polhode_parameters) == 0;
  if (bytes < sizeof(polhode_parameters) || !aligned) {
    return POLHODE_MEMORY_TOO_SMALL;
  }
  *out = ::new (memory) polhode_parameters;
  return POLHODE_OK;
}

polhode_status polhode_set_camera(polhode_parameters* parameters, const polhode_camera* camera) {
  if (parameters == nullptr || camera == nullptr) {
    return POLHODE_BAD_ARGUMENT;
  }
  parameters->values.camera = {.width_px = camera->width_px,
                               .height_px = camera->height_px,
                               .fu_px = camera->fu_px,
                               .fv_px = camera->fv_px,
                               .cu_px = camera->cu_px,
                               .cv_px = camera->cv_px,
                               .k1 = camera->k1,
                               .k2 = camera->k2,
                               .p1 = camera->p1,
                               .p2 = camera->p2,
                               .line_time_ns = parameters->values.camera.line_time_ns};
  return POLHODE_OK;
}

polhode_status polhode_set_real(polhode_parameters* parameters,
                                const char* key,
                                size_t index,
                                double value,
                                char* problem,
                                size_t problem_octets) {
  return set_bits({parameters, key, index}, &bits_of_real, value, problem, problem_octets);
}

polhode_status polhode_set_whole(polhode_parameters* parameters,
                                 const char* key,
                                 size_t index,
                                 int64_t value,
                                 char* problem,
                                 size_t problem_octets) {
  return set_bits({parameters, key, index}, &bits_of_whole, value, problem, problem_octets);
}

polhode_status polhode_check(const polhode_parameters* parameters,
                             char* problem,
                             size_t problem_octets) {
  return guarded([&] {
    if (parameters == nullptr) {
      write_problem("parameters: null", problem, problem_octets);
      return polhode_status{POLHODE_BAD_ARGUMENT};
    }
    const auto found = polhode::check(parameters->values);
    if (found) {
      write_problem(found->message, problem, problem_octets);
    }
    return polhode_status{found ? POLHODE_BAD_PARAMETER : POLHODE_OK};
  });
}
