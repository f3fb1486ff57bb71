// Point clouds and surfaces as PLY files.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace polhode::platform {

struct PlyCloud {
  std::span<const Eigen::Vector3d> points;
  std::span<const Eigen::Vector3d> normals;          ///< one a point, or none at all
  std::span<const std::array<std::uint8_t, 3>> rgb;  ///< one a point, or none at all
  std::span<const std::uint8_t> added =
      {};                             ///< 1: not measured, made by completion; one a point, or none
  std::span<const float> sigma = {};  ///< 1-sigma, worst axis, unit of the points; NaN: unknown
  std::span<const std::int32_t> views = {};     ///< keyframes that saw it; one a point, or none
  std::span<const std::int32_t> landmark = {};  ///< number of the landmark; one a point, or none
  std::span<const std::array<std::uint32_t, 3>> faces =
      {};                    ///< triangles, anticlockwise from outside
  std::string_view comment;  ///< one line: frame and unit
};

/// Binary, little-endian, float coordinates.
void write_ply(const std::filesystem::path& file, const PlyCloud& cloud);

}  // namespace polhode::platform
