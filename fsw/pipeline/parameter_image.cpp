#include "pipeline/parameter_image.hpp"

#include <bit>
#include <cmath>
#include <span>

#include "base/crc.hpp"
#include "bus/octets.hpp"

namespace polhode {
namespace {

/// One value of a row, as a number to check and as a place to write.
struct WriteBits {
  std::uint64_t bits;
  std::size_t index;
  const ParameterRow& row;
  Parameters& parameters;

  bool operator()(Member<bool> where) const { return whole(where, bits <= 1); }
  bool operator()(Member<int> where) const {
    const auto value = static_cast<std::int64_t>(bits);
    return whole(where, value >= INT32_MIN && value <= INT32_MAX);
  }
  bool operator()(Member<std::int64_t> where) const { return whole(where, true); }
  bool operator()(Member<std::uint64_t> where) const { return whole(where, true); }
  bool operator()(Member<double> where) const { return real(where(parameters)); }
  bool operator()(Member<MotionMode> where) const { return choice(where); }
  bool operator()(Member<DynamicsKind> where) const { return choice(where); }
  bool operator()(Member<PointPair> where) const {
    return real(where(parameters)[index / 2][index % 2]);
  }

 private:
  [[nodiscard]] bool in_range(double value) const {
    return std::isfinite(value) && value >= row.low && value <= row.high;
  }
  bool real(double& to) const {
    const double value = std::bit_cast<double>(bits);
    to = in_range(value) ? value : to;
    return in_range(value);
  }
  /// A choice, by its index among the allowed words.
  template <typename T>
  bool choice(Member<T> where) const {
    if (bits >= choices_of(T{}).size()) {
      return false;
    }
    where(parameters) = static_cast<T>(bits);
    return true;
  }
  template <typename T>
  bool whole(Member<T> where, bool fits) const {
    const auto value = static_cast<std::int64_t>(bits);
    if (!fits || !in_range(static_cast<double>(value))) {
      return false;
    }
    where(parameters) = static_cast<T>(value);
    return true;
  }
};

struct ReadBits {
  std::size_t index;
  Parameters& parameters;

  std::uint64_t operator()(Member<double> where) const {
    return std::bit_cast<std::uint64_t>(where(parameters));
  }
  std::uint64_t operator()(Member<PointPair> where) const {
    return std::bit_cast<std::uint64_t>(where(parameters)[index / 2][index % 2]);
  }
  template <typename T>
  std::uint64_t operator()(Member<T> where) const {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(where(parameters)));
  }
};

bool is_in_range(const ParameterRow& row, const Parameters& parameters) {
  Parameters copy = parameters;
  for (std::size_t i = 0; i < value_count(row); ++i) {
    if (!set_from_bits(row, i, bits_of(row, i, parameters), &copy)) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::uint32_t key_crc(std::string_view key) {
  return crc32_iso_hdlc(std::span(reinterpret_cast<const std::uint8_t*>(key.data()), key.size()));
}

const ParameterRow* find_parameter_by_crc(std::uint32_t crc) {
  for (const ParameterRow& row : parameter_table()) {
    if (key_crc(row.key) == crc) {
      return &row;
    }
  }
  return nullptr;
}

bool may_change_in_flight(std::string_view key) {
  return !key.starts_with("camera.") && !key.starts_with("scale.") && !key.starts_with("jobs.") &&
         !key.starts_with("budget.") && key != "seed" && key != "bus.apid_first";
}

std::size_t value_count(const ParameterRow& row) {
  return std::holds_alternative<Member<PointPair>>(row.member) ? 4 : 1;
}

bool set_from_bits(const ParameterRow& row,
                   std::size_t index,
                   std::uint64_t bits,
                   Parameters* parameters) {
  return index < value_count(row) &&
         std::visit(WriteBits{.bits = bits, .index = index, .row = row, .parameters = *parameters},
                    row.member);
}

std::uint64_t bits_of(const ParameterRow& row, std::size_t index, const Parameters& parameters) {
  return std::visit(ReadBits{.index = index, .parameters = readable(parameters)}, row.member);
}

std::uint32_t table_crc(const Parameters& parameters) {
  std::uint32_t crc = 0;
  for (const ParameterRow& row : parameter_table()) {
    for (std::size_t i = 0; i < value_count(row); ++i) {
      std::array<std::uint8_t, 12> octets{};
      bus::put_unsigned(octets, 0, key_crc(row.key), 4);
      bus::put_unsigned(octets, 4, bits_of(row, i, parameters), 8);
      crc = crc32_iso_hdlc(octets, crc);
    }
  }
  return crc;
}

std::string_view first_bad_key(const Parameters& parameters) {
  for (const ParameterRow& row : parameter_table()) {
    const bool elsewhere = row.key.starts_with("camera.") || row.key.starts_with("scale.");
    if (!elsewhere && !is_in_range(row, parameters)) {
      return row.key;
    }
  }
  const bool gap = parameters.start.chi2_gap_convexity > parameters.start.chi2_gap_commit;
  return gap ? std::string_view("start.chi2_gap_convexity") : std::string_view();
}

}  // namespace polhode
