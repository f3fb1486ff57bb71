#include "shape/scale_of_shape.hpp"

#include <cmath>

namespace polhode {
namespace {

// The limit of a length between two image points.
constexpr double kRelativeSigmaMax = 1.0 / kLengthSigmasMin;
// Factor on the sigmas of a rectangle. On the shipped sample the longest rectangle is 6 % too long,
// 2.6 of the sigmas with this factor.
constexpr double kRectangleSigmas = 2.0;

struct Length {
  double value = 0.0;
  double sigma = 0.0;
};

Result<ScaleEstimate> scale_of(const Length& length, double known_m) {
  if (!(length.value > 0.0) || !(length.sigma <= kRelativeSigmaMax * length.value)) {
    return ErrorCode::kDegenerate;
  }
  const double scale = known_m / length.value;
  return ScaleEstimate{.metres_per_mu = scale, .sigma = scale * length.sigma / length.value};
}

/// May an edge be the longest although one of its ends was not found?
bool may_be_longer(const Shape& shape, const Length& longest) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (shape.dimension_basis[k] != DimensionBasis::kSurfaces &&
        shape.dimensions(static_cast<Eigen::Index>(k)) > longest.value - longest.sigma) {
      return true;
    }
  }
  return false;
}

}  // namespace

Result<ScaleEstimate> scale_from_diameter(const Shape& shape, double diameter_m) {
  if (!(diameter_m > 0.0) || !std::isfinite(diameter_m)) {
    return ErrorCode::kBadParameter;
  }
  if (!shape.cylinder) {
    return ErrorCode::kNoConsensus;
  }
  return scale_of(
      {.value = 2.0 * shape.cylinder->radius, .sigma = 2.0 * shape.cylinder->sigma_radius},
      diameter_m);
}

Result<ScaleEstimate> scale_from_edge(const Shape& shape,
                                      double edge_m,
                                      std::optional<double> expected_metres_per_mu) {
  if (!(edge_m > 0.0) || !std::isfinite(edge_m)) {
    return ErrorCode::kBadParameter;
  }
  Length best;
  const auto offer = [&](double value, double sigma) {
    const auto misfit = [&](double length) {
      return std::abs(std::log(*expected_metres_per_mu * length / edge_m));
    };
    const bool better = !expected_metres_per_mu || best.value == 0.0
                            ? value > best.value
                            : value > 0.0 && misfit(value) < misfit(best.value);
    if (better) {
      best = {.value = value, .sigma = sigma};
    }
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    if (shape.box && shape.dimension_basis[k] == DimensionBasis::kSurfaces) {
      offer(shape.dimensions(axis), shape.sigma_dimensions(axis));
    }
  }
  if (best.value > 0.0 && !expected_metres_per_mu && may_be_longer(shape, best)) {
    return ErrorCode::kDegenerate;
  }
  if (best.value == 0.0) {
    // The end of a rectangle is the end of its points: up to a spacing before the edge, or beyond
    // it by noise.
    const double sigma = kRectangleSigmas * std::hypot(shape.spacing, shape.thickness);
    for (const Plane& plane : shape.planes) {
      offer(plane.extents.x(), sigma);
      offer(plane.extents.y(), sigma);
    }
  }
  if (best.value == 0.0) {
    return ErrorCode::kNoConsensus;
  }
  return scale_of(best, edge_m);
}

}  // namespace polhode
