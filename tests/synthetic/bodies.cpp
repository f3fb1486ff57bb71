#include "synthetic/bodies.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace polhode::synthetic {
namespace {

double between(double low, double high, Rng* rng) { return low + (high - low) * rng->uniform(); }

}  // namespace

Body cylinder(int points, double radius_m, double height_m, Rng* rng) {
  Body body;
  const double side = 2.0 * std::numbers::pi * radius_m * height_m;
  const double end = std::numbers::pi * radius_m * radius_m;
  for (int i = 0; i < points; ++i) {
    const double pick = rng->uniform() * (side + 2.0 * end);
    const double angle = between(0.0, 2.0 * std::numbers::pi, rng);
    const Eigen::Vector3d radial(std::cos(angle), std::sin(angle), 0.0);
    if (pick < side) {
      const double z = between(-0.5, 0.5, rng) * height_m;
      body.push_back({radius_m * radial + Eigen::Vector3d(0.0, 0.0, z), radial});
    } else {
      const double sign = pick < side + end ? 1.0 : -1.0;
      const double r = radius_m * std::sqrt(rng->uniform());
      body.push_back({r * radial + Eigen::Vector3d(0.0, 0.0, 0.5 * sign * height_m),
                      Eigen::Vector3d(0.0, 0.0, sign)});
    }
  }
  return body;
}

Body box(int points, const Eigen::Vector3d& size_m, Rng* rng) {
  const std::array<double, 3> area = {
      size_m.y() * size_m.z(), size_m.x() * size_m.z(), size_m.x() * size_m.y()};
  Body body;
  for (int i = 0; i < points; ++i) {
    double pick = rng->uniform() * (area[0] + area[1] + area[2]);
    Eigen::Index axis = 0;
    while (axis < 2 && pick >= area[static_cast<std::size_t>(axis)]) {
      pick -= area[static_cast<std::size_t>(axis++)];
    }
    const double sign = rng->uniform() < 0.5 ? -1.0 : 1.0;
    Eigen::Vector3d p(between(-0.5, 0.5, rng), between(-0.5, 0.5, rng), between(-0.5, 0.5, rng));
    p(axis) = 0.5 * sign;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    normal(axis) = sign;
    body.push_back({p.cwiseProduct(size_m), normal});
  }
  return body;
}

Body sphere(int points, double radius_m, Rng* rng) {
  Body body;
  for (int i = 0; i < points; ++i) {
    Eigen::Vector3d n(rng->normal(), rng->normal(), rng->normal());
    n.normalize();
    body.push_back({radius_m * n, n});
  }
  return body;
}

Body panel(int points, double width_m, double height_m, Rng* rng) {
  Body body;
  for (int i = 0; i < points; ++i) {
    const double sign = rng->uniform() < 0.5 ? -1.0 : 1.0;
    body.push_back({{between(-0.5, 0.5, rng) * width_m, between(-0.5, 0.5, rng) * height_m, 0.0},
                    {0.0, 0.0, sign}});
  }
  return body;
}

Body dish(int points, double radius_m, double depth_m, Rng* rng) {
  Body body;
  for (int i = 0; i < points; ++i) {
    const double r = radius_m * std::sqrt(rng->uniform());
    const double angle = between(0.0, 2.0 * std::numbers::pi, rng);
    const double slope = 2.0 * depth_m * r / (radius_m * radius_m);
    const double z = depth_m * (r * r / (radius_m * radius_m) - 0.5);
    const Eigen::Vector3d normal(-slope * std::cos(angle), -slope * std::sin(angle), 1.0);
    body.push_back({{r * std::cos(angle), r * std::sin(angle), z}, normal.normalized()});
  }
  return body;
}

Body satellite(int points, Rng* rng) {
  Body body = box(points / 2, {0.5, 0.4, 0.6}, rng);
  for (const double side : {-1.0, 1.0}) {
    for (SurfacePoint point : panel(points / 4, 0.5, 0.35, rng)) {
      point.p_B.x() += 0.55 * side;
      body.push_back(point);
    }
  }
  return body;
}

double radius_m(const Body& body) {
  double radius = 0.0;
  for (const SurfacePoint& point : body) {
    radius = std::max(radius, point.p_B.norm());
  }
  return radius;
}

}  // namespace polhode::synthetic
