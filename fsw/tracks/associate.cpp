#include "tracks/associate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/median.hpp"

namespace polhode {
namespace {

// Neighbours whose median motion predicts that of a place. Chosen: of eight, three may be wrong;
// eight lie within a few feature distances.
constexpr std::size_t kNeighbours = 8;
// Twice as many as the neighbours of one.
constexpr std::size_t kFieldMin = 2 * kNeighbours;

Eigen::Vector2d place_of(const Feature& feature) { return {feature.u_px, feature.v_px}; }

/// Motion field of a body's features between two frames: a common affine motion, plus a residual
/// from depth that neighbours share.
struct Field {
  struct Point {
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
    Eigen::Vector2d beside_affine_px = Eigen::Vector2d::Zero();
  };
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< of the matched features
  double extent_px = 0.0;                            ///< their RMS distance from it
  /// Maps (place - middle, 1) to the affine part of the motion.
  Eigen::Matrix<double, 2, 3> affine = Eigen::Matrix<double, 2, 3>::Zero();
  FixedVector<Point, limits::kFeatures> points;
  double tolerance_px = 0.0;  ///< a match that differs by more from its neighbours is wrong

  [[nodiscard]] Eigen::Vector2d affine_at(const Eigen::Vector2d& at) const {
    const Eigen::Vector2d from = at - middle;
    return at + affine.leftCols<2>() * from + affine.col(2);
  }
};

/// Median of the neighbours' residual motion.
/// @param itself  a point left out, or -1.
Eigen::Vector2d neighbours_px(const Field& field,
                              const Eigen::Vector2d& at,
                              std::ptrdiff_t itself) {
  struct Near {
    double distance2 = 0.0;
    std::size_t index = 0;
  };
  FixedVector<Near, kNeighbours> near;  // the nearest so far, in order
  for (std::size_t i = 0; i < field.points.size(); ++i) {
    const double distance2 = (field.points[i].at - at).squaredNorm();
    if (static_cast<std::ptrdiff_t>(i) == itself ||
        (near.full() && distance2 >= near.back().distance2)) {
      continue;
    }
    if (!near.full()) {
      (void)near.push_back({});
    }
    std::size_t k = near.size() - 1;
    for (; k > 0 && near[k - 1].distance2 > distance2; --k) {
      near[k] = near[k - 1];
    }
    near[k] = {.distance2 = distance2, .index = i};
  }
  Eigen::Vector2d motion_px = Eigen::Vector2d::Zero();
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    FixedVector<double, kNeighbours> values;
    for (const Near& n : near) {
      (void)values.push_back(field.points[n.index].beside_affine_px(axis));
    }
    motion_px(axis) = median(values.view());
  }
  return motion_px;
}

/// Middle and extent of the matched features of `a`.
void measure(std::span<const Feature> a, const FeatureMatches& matches, Field* field) {
  for (const FeatureMatch& match : matches) {
    field->middle += place_of(a[static_cast<std::size_t>(match.a)]);
  }
  const auto count = static_cast<double>(matches.size());
  field->middle /= count;
  double squares = 0.0;
  for (const FeatureMatch& match : matches) {
    squares += (place_of(a[static_cast<std::size_t>(match.a)]) - field->middle).squaredNorm();
  }
  field->extent_px = std::sqrt(squares / count);
}

/// Least squares under a Cauchy loss as wide as the residuals' median.
void fit_affine(std::span<const Feature> a,
                std::span<const Feature> b,
                const FeatureMatches& matches,
                Field* field) {
  constexpr int kRounds = 8;               // of reweighting; the weights settle by then
  constexpr double kWidthMin2_px2 = 0.25;  // half a pixel: the noise of a feature's place
  // A ridge, relative to the trace: for places on one line the motion across it is zero.
  constexpr double kRidge = 1e-9;
  double width2 = std::numeric_limits<double>::max();  // equal weights at first
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> g = Eigen::Matrix<double, 3, 2>::Zero();
    FixedVector<double, limits::kFeatures> errors2;
    for (const FeatureMatch& match : matches) {
      const Eigen::Vector2d at = place_of(a[static_cast<std::size_t>(match.a)]);
      const Eigen::Vector2d to = place_of(b[static_cast<std::size_t>(match.b)]);
      const Eigen::Vector2d from = at - field->middle;
      const Eigen::Vector3d x(from.x(), from.y(), 1.0);
      const double weight = 1.0 / (1.0 + (to - field->affine_at(at)).squaredNorm() / width2);
      H += weight * x * x.transpose();
      g += weight * x * (to - at).transpose();
    }
    H.diagonal().array() += kRidge * H.trace();
    field->affine = H.ldlt().solve(g).transpose();
    for (const FeatureMatch& match : matches) {
      (void)errors2.push_back((place_of(b[static_cast<std::size_t>(match.b)]) -
                               field->affine_at(place_of(a[static_cast<std::size_t>(match.a)])))
                                  .squaredNorm());
    }
    width2 = std::max(kWidthMin2_px2, median(errors2.view()));
  }
}

void add_points(std::span<const Feature> a,
                std::span<const Feature> b,
                const FeatureMatches& matches,
                Field* field) {
  field->points.clear();
  for (const FeatureMatch& match : matches) {
    const Eigen::Vector2d at = place_of(a[static_cast<std::size_t>(match.a)]);
    (void)field->points.push_back(
        {.at = at,
         .beside_affine_px =
             place_of(b[static_cast<std::size_t>(match.b)]) - field->affine_at(at)});
  }
}

/// Distance of each match's motion from its neighbours'.
FixedVector<double, limits::kFeatures> differences_px(const Field& field) {
  FixedVector<double, limits::kFeatures> apart_px;
  for (std::size_t i = 0; i < field.points.size(); ++i) {
    const Field::Point& point = field.points[i];
    const Eigen::Vector2d about = neighbours_px(field, point.at, static_cast<std::ptrdiff_t>(i));
    (void)apart_px.push_back((point.beside_affine_px - about).norm());
  }
  return apart_px;
}

/// Drops the matches that move otherwise than their neighbours, and estimates the field's noise.
/// @return false, with nothing dropped, where neighbours have no motion in common.
bool drop_strays(FeatureMatches* matches, Field* field) {
  const FixedVector<double, limits::kFeatures> apart_px = differences_px(*field);
  FixedVector<double, limits::kFeatures> sorted = apart_px;
  // The median of a distance in two dimensions is 1.18 sigma; 99.9 % lie within 3.7.
  constexpr double kSigmas = 3.7 / 1.18;
  constexpr double kToleranceMin_px = 1.5;  // three sigma of a feature's place in two frames
  // Relative to the extent: depth moves neighbours apart by less, by 0.1 at 10 deg of rotation.
  constexpr double kToleranceMost = 0.2;
  field->tolerance_px = std::max(kToleranceMin_px, kSigmas * median(sorted.view()));
  if (field->tolerance_px > std::max(kToleranceMin_px, kToleranceMost * field->extent_px)) {
    return false;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < matches->size(); ++i) {
    if (apart_px[i] <= field->tolerance_px) {
      (*matches)[kept] = (*matches)[i];
      field->points[kept++] = field->points[i];
    }
  }
  matches->resize(kept);
  field->points.resize(kept);
  return true;
}

struct SearchCircle {
  Eigen::Vector2d at_px;
  double radius_px = 0.0;
};

/// The feature of `b` within a circle whose descriptor is nearest to that of `feature`, if it
/// passes the ratio test among the features there.
FeatureMatch find_within(const SearchCircle& circle,
                         const Feature& feature,
                         std::span<const Feature> b,
                         std::span<const std::uint8_t> taken,
                         double ratio_max) {
  // Squared descriptor distance, checked with ray-cast depths: beyond it the median error is over
  // 0.7 px, three times a feature's sigma.
  constexpr int kDistance2About = 280 * 280;
  constexpr float kSamePlace_px = 1.0F;  // as in match_mutual()
  NearestFeature best;
  for (std::size_t j = 0; j < b.size(); ++j) {
    if (taken[j] == 0 &&
        (place_of(b[j]) - circle.at_px).squaredNorm() <= circle.radius_px * circle.radius_px) {
      const int d2 = distance2(feature.descriptor, b[j].descriptor);
      keep_nearest(static_cast<std::int32_t>(j), d2, b, kSamePlace_px, &best);
    }
  }
  const bool alike = best.nearest2 <= kDistance2About;
  const bool stands_out = best.nearest2 <= ratio_max * ratio_max * best.rival2;
  return alike && stands_out ? FeatureMatch{.b = best.feature, .distance2 = best.nearest2}
                             : FeatureMatch{};
}

/// Adds matches of unmatched features, searched for at the displacement of their neighbours. One to
/// one.
void add_found_about(std::span<const Feature> a,
                     std::span<const Feature> b,
                     const Field& field,
                     double ratio_max,
                     FeatureMatches* matches) {
  FixedVector<std::uint8_t, limits::kFeatures> matched_a;
  FixedVector<std::uint8_t, limits::kFeatures> matched_b;
  FixedVector<FeatureMatch, limits::kFeatures> wanted;  // by feature of `b`
  matched_a.resize(a.size());
  matched_b.resize(b.size());
  wanted.resize(b.size());
  std::fill(matched_a.begin(), matched_a.end(), std::uint8_t{0});
  std::fill(matched_b.begin(), matched_b.end(), std::uint8_t{0});
  std::fill(wanted.begin(), wanted.end(), FeatureMatch{});
  for (const FeatureMatch& match : *matches) {
    matched_a[static_cast<std::size_t>(match.a)] = 1;
    matched_b[static_cast<std::size_t>(match.b)] = 1;
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (matched_a[i] != 0) {
      continue;
    }
    const Eigen::Vector2d from = place_of(a[i]);
    const SearchCircle circle{.at_px = field.affine_at(from) + neighbours_px(field, from, -1),
                              .radius_px = field.tolerance_px};
    FeatureMatch found = find_within(circle, a[i], b, matched_b.view(), ratio_max);
    if (found.b < 0) {
      continue;
    }
    found.a = static_cast<std::int32_t>(i);
    FeatureMatch& other = wanted[static_cast<std::size_t>(found.b)];
    if (other.a < 0 || found.distance2 < other.distance2) {
      other = found;
    }
  }
  for (const FeatureMatch& match : wanted) {
    if (match.a >= 0) {
      (void)matches->push_back(match);
    }
  }
  std::sort(matches->begin(), matches->end(), [](const FeatureMatch& l, const FeatureMatch& r) {
    return l.a < r.a;
  });
}

}  // namespace

void associate(std::span<const Feature> a,
               std::span<const Feature> b,
               double ratio_max,
               FeatureMatches* matches) {
  match_mutual(a, b, ratio_max, matches);
  if (matches->size() < kFieldMin) {
    return;
  }
  Field field;
  measure(a, *matches, &field);
  fit_affine(a, b, *matches, &field);
  add_points(a, b, *matches, &field);
  if (drop_strays(matches, &field) && field.points.size() >= kFieldMin) {
    add_found_about(a, b, field, ratio_max, matches);
  }
}

}  // namespace polhode
