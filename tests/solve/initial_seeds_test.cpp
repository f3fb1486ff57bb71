#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "solve/affine_factorisation.hpp"
#include "solve/constant_rate_grid.hpp"
#include "solve/homography.hpp"
#include "solve/initial_geometry.hpp"
#include "solve/relative_pose.hpp"

namespace polhode::initial_seeds_test {
namespace {

using testing::InitialGeometry;
using testing::make_initial_geometry;

struct Pairs {
  std::vector<Eigen::Vector2d> a;
  std::vector<Eigen::Vector2d> b;
  RelativePose truth;
};

Pairs first_and_last(const InitialGeometry& g) {
  Pairs pairs;
  const int last = static_cast<int>(g.poses.size()) - 1;
  for (const TrackObservation& s : g.observations) {
    if (s.frame == 0) {
      pairs.a.push_back(s.normalised);
    } else if (s.frame == last) {
      pairs.b.push_back(s.normalised);
    }
  }
  pairs.truth =
      relative_pose(from_inverse_depth(g.poses.front()), from_inverse_depth(g.poses.back()));
  pairs.truth.p_ba.normalize();
  return pairs;
}

ImageMatrix images_of(const InitialGeometry& g) {
  const auto frames = static_cast<Eigen::Index>(g.poses.size());
  ImageMatrix images(2 * frames, static_cast<Eigen::Index>(g.points_T.size()));
  for (const TrackObservation& s : g.observations) {
    images(s.frame, s.track) = s.normalised.x();
    images(frames + s.frame, s.track) = s.normalised.y();
  }
  return images;
}

/// Angle between the turn of the motion and the truth's, or its depth-reversed solution's,
/// whichever is nearer.
double turn_error_rad(const Eigen::Matrix3d& turn, const Eigen::Matrix3d& truth) {
  const Eigen::DiagonalMatrix<double, 3> flip(1.0, 1.0, -1.0);
  return std::min(rotation_angle_rad(turn, truth), rotation_angle_rad(turn, flip * truth * flip));
}

TEST(RelativePoses, FindTheExactMotion_WithoutNoise) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const InitialGeometry g = make_initial_geometry({.extent_over_range = 0.2}, seed);
    const Pairs pairs = first_and_last(g);
    const RelativePoseCandidates found =
        find_relative_poses(pairs.a, pairs.b, {.sigma_normalised = 1e-6, .seed = seed});
    ASSERT_FALSE(found.empty()) << seed;
    EXPECT_LT(rotation_angle_rad(found[0].motion.R_ba, pairs.truth.R_ba), 1e-6) << seed;
    EXPECT_LT((found[0].motion.p_ba - pairs.truth.p_ba).norm(), 1e-6) << seed;
  }
}

TEST(RelativePoses, SurviveOneWrongPairInFive) {
  InitialGeometry g = make_initial_geometry(
      {.points = 60, .extent_over_range = 0.25, .sigma = 2e-4, .noise = 1.0}, 4);
  Pairs pairs = first_and_last(g);
  Rng rng(1, 1);
  for (std::size_t i = 0; i < pairs.a.size(); i += 5) {
    pairs.b[i] += 0.05 * Eigen::Vector2d(rng.normal(), rng.normal());
  }
  const RelativePoseCandidates found =
      find_relative_poses(pairs.a, pairs.b, {.sigma_normalised = 2e-4, .seed = 9});
  ASSERT_FALSE(found.empty());
  EXPECT_GE(found[0].inliers, 40);
  EXPECT_LT(rotation_angle_rad(found[0].motion.R_ba, pairs.truth.R_ba), 0.1);
}

TEST(RelativePoses, AreNone_WhenPairsAreTooFew) {
  const std::vector<Eigen::Vector2d> few(7, Eigen::Vector2d(0.1, 0.2));
  EXPECT_TRUE(find_relative_poses(few, few, {}).empty());
}

TEST(Homography, KeepsBothNormals_OfAFlatPanel) {
  int both = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const InitialGeometry g = make_initial_geometry({.extent_over_range = 0.1, .flat = true}, seed);
    const Pairs pairs = first_and_last(g);
    const HomographyFit fit = find_homography(pairs.a, pairs.b, {.sigma_normalised = 1e-6});
    EXPECT_EQ(fit.inliers, static_cast<int>(pairs.a.size())) << seed;
    double best = 1e300;
    for (const PanelMotion& m : fit.motions) {
      best = std::min(best, rotation_angle_rad(m.motion.R_ba, pairs.truth.R_ba));
    }
    EXPECT_LT(best, 1e-5) << seed;
    both += fit.motions.size() == 2 ? 1 : 0;
  }
  // The other normal lies behind the camera where the panel is seen at a slant: not in most
  // attitudes.
  EXPECT_GE(both, 5);
}

TEST(AffineFactorisation, RecoversTheTurnOfADistantBody_WithWrongTracks) {
  // Perspective shows in extent / range = 1e-3 of the relief: turns come out as exact as that.
  InitialGeometry g = make_initial_geometry(
      {.points = 50, .frames = 8, .turn_rad = 0.8, .extent_over_range = 1e-3, .on_axis = true}, 6);
  ImageMatrix images = images_of(g);
  Rng rng(2, 2);
  for (Eigen::Index i = 0; i < images.cols(); i += 5) {
    for (Eigen::Index f = 0; f < images.rows(); ++f) {
      images(f, i) += 2e-4 * rng.normal();
    }
  }
  const AffineSubspace subspace = find_affine_subspace(images, 1e-6, 1);
  ASSERT_TRUE(subspace.valid);
  EXPECT_EQ(subspace.inliers, 40);
  WeakPerspectiveMotion motion;
  ASSERT_TRUE(upgrade_to_metric(subspace, 0.0, &motion));
  const Eigen::Matrix3d truth = g.poses[7].R_CT * g.poses[0].R_CT.transpose();
  EXPECT_LT(turn_error_rad(motion.R_CT[7] * motion.R_CT[0].transpose(), truth), 0.02);
}

TEST(ConstantRate, RecoversTheRate_OfADistantBody) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    InitialGeometry g = make_initial_geometry(
        {.points = 50, .frames = 8, .turn_rad = 0.5, .extent_over_range = 1e-3, .on_axis = true},
        seed);
    const ImageMatrix images = images_of(g);
    const std::vector<std::uint8_t> all(g.points_T.size(), 1);
    const ConstantRateMotions found = search_constant_rate(centred(images, all), g.times_s);
    ASSERT_FALSE(found.empty());
    const WeakPerspectiveMotion motion = to_motion(found[0], g.times_s);
    const Eigen::Matrix3d truth = g.poses[7].R_CT * g.poses[0].R_CT.transpose();
    EXPECT_LT(turn_error_rad(motion.R_CT[7] * motion.R_CT[0].transpose(), truth), 0.02) << seed;
  }
}

/// Times of years and of nanoseconds in one start coincide as numbers.
TEST(ConstantRate, WhereNoTimePassesThereIsNone) {
  InitialGeometry g =
      make_initial_geometry({.points = 50, .frames = 8, .turn_rad = 0.5, .on_axis = true}, 1);
  const std::vector<std::uint8_t> all(g.points_T.size(), 1);
  for (const double last_s : {3.0, 2.0, std::numeric_limits<double>::quiet_NaN()}) {
    std::vector<double> times_s(8, 3.0);
    times_s.back() = last_s;
    EXPECT_TRUE(search_constant_rate(centred(images_of(g), all), times_s).empty()) << last_s;
  }
}

TEST(WeakPerspective, PointsAreThoseOfTheMotion) {
  InitialGeometry g = make_initial_geometry(
      {.points = 30, .frames = 5, .extent_over_range = 1e-4, .on_axis = true}, 8);
  const ImageMatrix images = images_of(g);
  const std::vector<std::uint8_t> all(g.points_T.size(), 1);
  WeakPerspectiveMotion motion;
  for (const InverseDepthPose& pose : g.poses) {
    (void)motion.R_CT.push_back(pose.R_CT);
    (void)motion.scale.push_back(pose.uvs.z());
  }
  const Eigen::Matrix3Xd points = weak_perspective_points(images, all, motion);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : g.points_T) {
    mean += p / static_cast<double>(g.points_T.size());
  }
  for (std::size_t i = 0; i < g.points_T.size(); ++i) {
    // Relief / range is 1e-4; depth, from a turn of 0.6 rad, is a few times less certain than the
    // sides.
    EXPECT_LT((points.col(static_cast<Eigen::Index>(i)) - (g.points_T[i] - mean)).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace polhode::initial_seeds_test
