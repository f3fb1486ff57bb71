// Point clouds of known bodies for the tests of shape: spread at random over surfaces, with noise
// and stray points.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "shape/shape.hpp"

namespace polhode {

using Points = std::vector<Eigen::Vector3d>;

struct Placement {
  Eigen::Matrix3d R_TB = so3_exp({0.3, -0.5, 0.8});
  Eigen::Vector3d centre_T{0.7, -1.3, 2.1};
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3d& p_B) const {
    return R_TB * p_B + centre_T;
  }
};

inline Eigen::Vector3d noise(Rng& rng, double sigma) {
  return sigma * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
}

/// Points on the sides of a box, as many per area on each; `sides` holds -x, +x, -y, +y, -z, +z.
inline Points box_points(const Eigen::Vector3d& dimensions,
                         const std::array<bool, 6>& sides,
                         int count,
                         double sigma,
                         std::uint64_t seed,
                         const Placement& at = {}) {
  Rng rng(seed, 1);
  std::array<double, 6> areas{};
  double total = 0.0;
  for (std::size_t s = 0; s < 6; ++s) {
    areas[s] = sides[s] ? dimensions.prod() / dimensions(static_cast<Eigen::Index>(s / 2)) : 0.0;
    total += areas[s];
  }
  Points points;
  for (int i = 0; i < count; ++i) {
    double draw = total * rng.uniform();
    std::size_t s = 0;
    while (s < 5 && (draw >= areas[s] || areas[s] == 0.0)) draw -= areas[s++];
    while (areas[s] == 0.0) --s;
    Eigen::Vector3d p;
    for (Eigen::Index k = 0; k < 3; ++k) p(k) = dimensions(k) * (rng.uniform() - 0.5);
    p(static_cast<Eigen::Index>(s / 2)) =
        dimensions(static_cast<Eigen::Index>(s / 2)) * (s % 2 == 0 ? -0.5 : 0.5);
    points.push_back(at.place(p) + noise(rng, sigma));
  }
  return points;
}

inline constexpr std::array<bool, 6> kAllSides{true, true, true, true, true, true};

/// Points on the round part (over `arc_rad`) and the two ends of a cylinder along B's z.
inline Points cylinder_points(double radius,
                              double length,
                              double arc_rad,
                              int count,
                              double sigma,
                              std::uint64_t seed,
                              const Placement& at = {}) {
  Rng rng(seed, 2);
  const double round = arc_rad * radius * length;
  const double ends = std::numbers::pi * radius * radius * 2.0;
  Points points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p;
    if (rng.uniform() * (round + ends) < round) {
      const double angle = arc_rad * rng.uniform();
      p = {radius * std::cos(angle), radius * std::sin(angle), length * (rng.uniform() - 0.5)};
    } else {
      const double angle = 2.0 * std::numbers::pi * rng.uniform();
      const double r = radius * std::sqrt(rng.uniform());
      p = {r * std::cos(angle),
           r * std::sin(angle),
           rng.below(2) == 0 ? -0.5 * length : 0.5 * length};
    }
    points.push_back(at.place(p) + noise(rng, sigma));
  }
  return points;
}

/// Stray points in a cube of the given half width around the placement.
inline void add_strays(
    Points& points, int count, double half_width, std::uint64_t seed, const Placement& at = {}) {
  Rng rng(seed, 3);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p(rng.uniform() - 0.5, rng.uniform() - 0.5, rng.uniform() - 0.5);
    points.push_back(at.centre_T + 2.0 * half_width * p);
  }
}

inline double angle_between_axes(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::asin(std::min(1.0, a.cross(b).norm()));
}

inline std::unique_ptr<ShapeWork> new_work() { return std::make_unique<ShapeWork>(); }

}  // namespace polhode
