// Conversions to the number types of a packet.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace polhode::bus {

/// Larger numbers become the largest one that fits.
inline std::uint16_t clipped(std::size_t count) {
  return static_cast<std::uint16_t>(std::min<std::size_t>(count, 0xFFFF));
}

inline std::uint8_t clipped_to_octet(std::size_t count) {
  return static_cast<std::uint8_t>(std::min<std::size_t>(count, 0xFF));
}

inline std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Rounded to binary32.
template <std::size_t kCount>
std::array<float, kCount> narrowed(const std::array<double, kCount>& values) {
  std::array<float, kCount> out{};
  std::transform(values.begin(), values.end(), out.begin(), [](double value) {
    return static_cast<float>(value);
  });
  return out;
}

}  // namespace polhode::bus
