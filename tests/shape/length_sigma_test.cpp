// Does the truth lie where the sigma of a length indicates? Ends at edges, where the surface beside
// them is another one, and maps that are bent.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "shape/scale.hpp"
#include "surfaces.hpp"

namespace polhode::length_sigma_test {
namespace {

constexpr double kMetresPerMu = 0.37;
constexpr double kFocal_px = 800.0;
constexpr double kPick = 1.0 / kFocal_px;  // a point is picked to a pixel
constexpr int kDraws = 120;

/// What one draw shows, and what is known of it.
struct Drawn {
  Points landmarks_T;
  std::vector<double> sigmas_mu;
  Pose pose;
  double relief_sigma = 0.0;
  Eigen::Vector3d end_a, end_b;  ///< in T, as they are

  [[nodiscard]] Eigen::Vector2d picked(const Eigen::Vector3d& end_T, Rng* rng) const {
    return pose.to_camera(end_T).hnormalized() +
           kPick * Eigen::Vector2d(rng->normal(), rng->normal());
  }
};

/// How draws came out: errors of the scale over its sigma.
struct Outcome {
  std::vector<double> normalised;
  int refused = 0;

  [[nodiscard]] double median() const {
    std::vector<double> sorted = normalised;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
  [[nodiscard]] double part_within_3_sigma() const {
    const auto within = std::count_if(
        normalised.begin(), normalised.end(), [](double value) { return value <= 3.0; });
    return static_cast<double>(within) / static_cast<double>(normalised.size());
  }
};

template <typename Draw>
Outcome outcome_of(const Draw& draw) {
  Outcome outcome;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    Rng rng(seed, 41);
    const Drawn drawn = draw(&rng, seed);
    const ScaleView view{.pose = drawn.pose,
                         .landmarks_T = drawn.landmarks_T,
                         .sigmas_mu = drawn.sigmas_mu,
                         .relief_sigma = drawn.relief_sigma};
    const double known_m = kMetresPerMu * (drawn.end_b - drawn.end_a).norm();
    const Eigen::Vector2d a = drawn.picked(drawn.end_a, &rng);
    const Eigen::Vector2d b = drawn.picked(drawn.end_b, &rng);
    const Result<ScaleEstimate> scale = scale_from_length(view, a, b, known_m, kPick);
    if (scale) {
      outcome.normalised.push_back(std::abs(scale.value().metres_per_mu - kMetresPerMu) /
                                   scale.value().sigma);
    } else {
      ++outcome.refused;
    }
  }
  return outcome;
}

/// Truth within 3 sigma in 95 of 100, and sigmas that fit the errors: of normal ones half lie
/// within 0.67 sigma. Doubt between surfaces is either right or far off, so the median is less
/// there.
void expect_honest(const Outcome& outcome, double part_refused_most) {
  EXPECT_LE(outcome.refused, part_refused_most * kDraws);
  ASSERT_GT(outcome.normalised.size(), kDraws / 4U);
  EXPECT_GE(outcome.part_within_3_sigma(), 0.95);
  EXPECT_GT(outcome.median(), 0.3);
  EXPECT_LT(outcome.median(), 1.5);
}

/// A turn that shows a side facing the camera, and its neighbours where it is large.
Pose facing(Rng* rng, double most_rad) {
  const auto angle = [&] { return most_rad * (2.0 * rng->uniform() - 1.0); };
  return {.R_CT = so3_exp({angle(), angle(), 3.0 * angle()}), .p_CT = {0.1, -0.05, 6.0}};
}

constexpr double kHalfPlate = 0.4;

/// A plate at z = 0, its edges at x = -0.4 and 0.4, `gap` before a wall; T's -z faces the camera.
/// Both have as many landmarks per area; what the plate hides is not seen. The ends are on its
/// edges.
Drawn plate_before_wall(double gap, Rng* rng) {
  constexpr double kNoise = 0.004;
  Drawn drawn;
  drawn.pose = facing(rng, 0.3);
  const Eigen::Vector3d eye_T = -(drawn.pose.R_CT.transpose() * drawn.pose.p_CT);
  for (int i = 0; i < 600; ++i) {
    Eigen::Vector3d p(1.8 * (rng->uniform() - 0.5), 1.8 * (rng->uniform() - 0.5), 0.0);
    const auto on_plate = [](const Eigen::Vector3d& q) {
      return std::abs(q.x()) < kHalfPlate && std::abs(q.y()) < kHalfPlate;
    };
    if (!on_plate(p)) {
      p.z() = gap;
      const Eigen::Vector3d crossing = eye_T + (p - eye_T) * (eye_T.z() / (eye_T.z() - gap));
      if (on_plate(crossing)) {
        continue;
      }
    }
    drawn.landmarks_T.push_back(p + noise(*rng, kNoise));
    drawn.sigmas_mu.push_back(kNoise);
  }
  drawn.end_a = {-kHalfPlate, 0.6 * (rng->uniform() - 0.5), 0.0};
  drawn.end_b = {kHalfPlate, 0.6 * (rng->uniform() - 0.5), 0.0};
  return drawn;
}

// verifies: SHP-16
TEST(LengthSigma, HoldsTheTruth_WhereAPlatesEdgesAreBeforeAWall) {
  for (const double gap : {0.1, 0.3, 0.6}) {
    SCOPED_TRACE(gap);
    expect_honest(
        outcome_of([gap](Rng* rng, std::uint64_t) { return plate_before_wall(gap, rng); }), 0.5);
  }
}

/// A box before nothing. The length is an edge of it, from corner to corner: both ends are where
/// the body ends, and no landmarks are nearer to any edge than 0.04.
Drawn box_with_a_known_edge(Rng* rng, std::uint64_t seed) {
  constexpr double kNoise = 0.005;
  const Eigen::Vector3d size(1.0, 0.8, 0.6);
  Drawn drawn;
  drawn.pose = facing(rng, 0.25);
  drawn.pose.R_CT = drawn.pose.R_CT * so3_exp({0.3, 0.4, 0.1});
  const Placement at{.R_TB = Eigen::Matrix3d::Identity(), .centre_T = Eigen::Vector3d::Zero()};
  for (const Eigen::Vector3d& p :
       box_points(size, {false, true, true, false, true, false}, 700, 0.0, seed, at)) {
    const Eigen::Vector3d from_edges = (p.cwiseAbs() - 0.5 * size).cwiseAbs();
    if ((from_edges.array() < 0.04).count() == 1) {
      drawn.landmarks_T.push_back(p + noise(*rng, kNoise));
      drawn.sigmas_mu.push_back(kNoise);
    }
  }
  drawn.end_a = {-0.5, -0.4, -0.3};
  drawn.end_b = {0.5, -0.4, -0.3};
  return drawn;
}

// verifies: SHP-16
TEST(LengthSigma, HoldsTheTruth_OfABoxesEdge) {
  expect_honest(outcome_of(box_with_a_known_edge), 0.2);
}

// verifies: SHP-16
TEST(LengthSigma, HoldsTheTruth_InABentMap) {
  // Neighbours are off by the same: depths by a wave over the body, and all by a factor.
  expect_honest(outcome_of([](Rng* rng, std::uint64_t seed) {
                  constexpr double kWave = 0.02;
                  constexpr double kRelief = 0.1;
                  Drawn drawn = box_with_a_known_edge(rng, seed);
                  const Eigen::Vector3d axis_T = drawn.pose.R_CT.row(2);
                  const Eigen::Vector3d along_T = std::numbers::pi * noise(*rng, 1.0).normalized();
                  const double phase = 2.0 * std::numbers::pi * rng->uniform();
                  const double factor = 1.0 + kRelief * rng->normal();
                  for (std::size_t i = 0; i < drawn.landmarks_T.size(); ++i) {
                    Eigen::Vector3d& p = drawn.landmarks_T[i];
                    const double wave =
                        std::numbers::sqrt2 * kWave * std::sin(along_T.dot(p) + phase);
                    p += (wave + (factor - 1.0) * axis_T.dot(p)) * axis_T;
                    drawn.sigmas_mu[i] = kWave / 2.0;  // what image points say is half of it
                  }
                  drawn.relief_sigma = kRelief;
                  return drawn;
                }),
                0.3);
}

TEST(LengthSigma, IsNoLargerOnAPlainSurface) {
  // Ends 0.2 inside the plate, the wall far from both: what is in doubt elsewhere is no doubt here.
  const Outcome outcome = outcome_of([](Rng* rng, std::uint64_t) {
    Drawn drawn = plate_before_wall(0.3, rng);
    drawn.end_a.x() = -0.2;
    drawn.end_b.x() = 0.2;
    return drawn;
  });
  EXPECT_LE(outcome.refused, 0.1 * kDraws);
  EXPECT_GT(outcome.median(), 0.2);
}

}  // namespace
}  // namespace polhode::length_sigma_test
