#include "solve/initial_adjustment.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <limits>
#include <memory>
#include <vector>

#include "solve/initial_geometry.hpp"

namespace polhode::initial_adjustment_test {
namespace {

using testing::disturb;
using testing::InitialGeometry;
using testing::make_initial_geometry;

std::unique_ptr<InitialAdjustmentWorkspace> workspace() {
  return std::make_unique<InitialAdjustmentWorkspace>();
}

/// Largest difference between the geometry's images and the observations, in sigma.
double worst_image(InitialGeometry* g) {
  double worst = 0.0;
  for (const TrackObservation& s : g->observations) {
    Eigen::Vector2d x;
    EXPECT_TRUE(reproject(g->poses[static_cast<std::size_t>(s.frame)],
                          g->points_T[static_cast<std::size_t>(s.track)],
                          &x));
    worst = std::max(worst, (x - s.normalised).norm() / s.sigma_normalised);
  }
  return worst;
}

TEST(InitialAdjustment, RecoversExactGeometry_WithoutNoise) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    InitialGeometry g = make_initial_geometry({}, seed);
    InitialGeometry truth = g;
    disturb(0.03, 0.05, seed, &g);
    ASSERT_TRUE(normalise_gauge(truth.view()));
    const auto w = workspace();
    (void)adjust_initial(g.observations,
                         g.view(),
                         {.iterations_max = 50, .loss = InitialLoss::kCauchy, .width_sigma = 30.0},
                         w.get());
    const InitialFit fit =
        adjust_initial(g.observations, g.view(), {.iterations_max = 50, .settled = 1e-12}, w.get());
    EXPECT_LT(fit.cost, 1e-6) << seed;
    ASSERT_TRUE(normalise_gauge(g.view()));
    for (std::size_t i = 0; i < g.points_T.size(); ++i) {
      // 1e-6 of cost is 1e-3 sigma at most; a sigma is 1e-4 / 0.05 = 2e-3 extents.
      EXPECT_LT((g.points_T[i] - truth.points_T[i]).norm(), 1e-4) << seed;
    }
  }
}

TEST(InitialAdjustment, GradientVanishesAtTheMinimum_NumericallyChecked) {
  InitialGeometry g = make_initial_geometry({.points = 12, .frames = 4, .noise = 1.0}, 3);
  const auto w = workspace();
  const InitialAdjustmentOptions options{
      .iterations_max = 100, .loss = InitialLoss::kCauchy, .settled = 1e-12};
  const double minimum = adjust_initial(g.observations, g.view(), options, w.get()).cost;
  // With the analytic Jacobians wrong anywhere, the minimum found would not be one of the cost
  // itself.
  const auto moved_cost = [&](const InitialGeometry& moved) {
    InitialGeometry copy = moved;
    return evaluate_initial(copy.observations, copy.view(), options, w.get()).cost;
  };
  for (std::size_t f = 0; f < g.poses.size(); ++f) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      for (const double step : {-1e-4, 1e-4}) {
        InitialGeometry turned = g;
        turned.poses[f].R_CT = so3_exp(step * Eigen::Vector3d::Unit(k)) * turned.poses[f].R_CT;
        EXPECT_GE(moved_cost(turned), minimum - 1e-9);
        InitialGeometry shifted = g;
        shifted.poses[f].uvs(k) += step * g.poses[f].uvs.z();
        EXPECT_GE(moved_cost(shifted), minimum - 1e-9);
      }
    }
  }
}

TEST(InitialAdjustment, LeavesWrongTracksAside) {
  InitialGeometry g = make_initial_geometry({.points = 60, .noise = 1.0}, 5);
  InitialGeometry truth = g;
  ASSERT_TRUE(normalise_gauge(truth.view()));
  Rng rng(1, 1);
  for (TrackObservation& s : g.observations) {
    if (s.track % 5 == 0) {
      s.normalised += 15e-4 * Eigen::Vector2d(rng.normal(), rng.normal());  // 15 sigma
    }
  }
  const auto w = workspace();
  (void)adjust_initial(g.observations,
                       g.view(),
                       {.iterations_max = 20, .loss = InitialLoss::kCauchy, .width_sigma = 3.0},
                       w.get());
  const InitialFit fit = adjust_initial(g.observations, g.view(), {.iterations_max = 30}, w.get());
  EXPECT_GE(fit.inliers, 48 * 6 * 95 / 100);
  EXPECT_LE(fit.inliers, 48 * 6);
  EXPECT_LT(rotation_angle_rad(g.poses[5].R_CT * g.poses[0].R_CT.transpose(),
                               truth.poses[5].R_CT * truth.poses[0].R_CT.transpose()),
            0.02);
}

TEST(InitialAdjustment, NoiseScaleTellsHowWrongTheClaimIs) {
  for (const double factor : {1.0, 2.0}) {
    InitialGeometry g = make_initial_geometry({.points = 80, .frames = 8, .noise = factor}, 7);
    const auto w = workspace();
    const InitialFit fit = adjust_initial(
        g.observations, g.view(), {.iterations_max = 30, .loss = InitialLoss::kCauchy}, w.get());
    // The median of 640 squared residuals scatters by 5 %, its root by 3 %; three of those.
    EXPECT_NEAR(fit.noise_scale / factor, 1.0, 0.1);
  }
}

TEST(InitialAdjustment, NormaliseGauge_KeepsTheImages) {
  InitialGeometry g = make_initial_geometry({}, 11);
  ASSERT_TRUE(normalise_gauge(g.view()));
  EXPECT_LT(worst_image(&g), 1e-7);
  EXPECT_TRUE(g.poses[0].R_CT.isIdentity(1e-12));
}

TEST(InitialAdjustment, NormaliseGauge_ChangesNothing_WhereAPoseIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& uvs : {Eigen::Vector3d(nan, 0.0, 0.1),
                                     Eigen::Vector3d(0.0, infinity, 0.1),
                                     Eigen::Vector3d(0.0, 0.0, 0.0),
                                     Eigen::Vector3d(0.0, 0.0, -0.1)}) {
    InitialGeometry g = make_initial_geometry({}, 11);
    g.poses[3].uvs = uvs;
    const InitialGeometry before = g;
    EXPECT_FALSE(normalise_gauge(g.view())) << uvs.transpose();
    EXPECT_EQ(g.poses[0].uvs, before.poses[0].uvs);
    EXPECT_EQ(g.points_T, before.points_T);
  }
}

TEST(InitialAdjustment, SinglePose_ThatCannotBeEvaluatedIsNone) {
  InitialGeometry g = make_initial_geometry({}, 11);
  InverseDepthPose pose = g.poses[1];
  pose.uvs.z() = -0.1;
  std::vector<TrackObservation> of_frame;
  for (const TrackObservation& o : g.observations) {
    if (o.frame == 1) {
      of_frame.push_back(o);
    }
  }
  EXPECT_EQ(adjust_single_pose(of_frame, g.view(), {.iterations_max = 5}, &pose), -1.0);
}

TEST(InitialAdjustment, ReverseDepth_ChangesImagesInSecondOrderOnly) {
  // The images change by relief / range of themselves: halving the size over range quarters the
  // change.
  double last = 0.0;
  for (const double size : {0.02, 0.01, 0.005}) {
    InitialGeometry g = make_initial_geometry({.extent_over_range = size, .sigma = 1.0}, 13);
    apply_depth_reversal(g.view());
    const double change = worst_image(&g);
    if (last > 0.0) {
      EXPECT_NEAR(change / last, 0.25, 0.05);
    }
    last = change;
  }
}

TEST(InitialAdjustment, ReverseDepthTwice_IsTheSame) {
  InitialGeometry g = make_initial_geometry({}, 17);
  apply_depth_reversal(g.view());
  apply_depth_reversal(g.view());
  EXPECT_LT(worst_image(&g), 1e-7);
}

TEST(InitialAdjustment, SinglePose_FindsItsWayFromTenDegrees) {
  InitialGeometry g = make_initial_geometry({.points = 30, .noise = 1.0}, 19);
  std::vector<TrackObservation> own;
  for (const TrackObservation& s : g.observations) {
    if (s.frame == 3) {
      own.push_back(s);
    }
  }
  InverseDepthPose pose = g.poses[3];
  pose.R_CT = so3_exp({0.1, -0.12, 0.08}) * pose.R_CT;
  InitialAdjustmentOptions options{
      .iterations_max = 20, .loss = InitialLoss::kCauchy, .width_sigma = 30.0};
  EXPECT_GE(adjust_single_pose(own, g.view(), options, &pose), 0.0);
  options.width_sigma = 3.0;
  EXPECT_GE(adjust_single_pose(own, g.view(), options, &pose), 0.0);
  EXPECT_LT(rotation_angle_rad(pose.R_CT, g.poses[3].R_CT), 0.01);
}

/// Covariance by the dense pseudo-inverse and projection onto the gauge's constraints, all
/// derivatives numeric.
Eigen::MatrixXd dense_point_covariance(InitialGeometry* g) {
  const auto frames = static_cast<Eigen::Index>(g->poses.size());
  const auto points = static_cast<Eigen::Index>(g->points_T.size());
  const Eigen::Index size = 6 * frames + 3 * points;
  const auto images = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd out(2 * static_cast<Eigen::Index>(g->observations.size()));
    for (std::size_t i = 0; i < g->observations.size(); ++i) {
      const TrackObservation& s = g->observations[i];
      InverseDepthPose pose = g->poses[static_cast<std::size_t>(s.frame)];
      pose.R_CT = so3_exp(x.segment<3>(6 * s.frame)) * pose.R_CT;
      pose.uvs += x.segment<3>(6 * s.frame + 3);
      const Eigen::Vector3d p =
          g->points_T[static_cast<std::size_t>(s.track)] + x.segment<3>(6 * frames + 3 * s.track);
      Eigen::Vector2d image;
      EXPECT_TRUE(reproject(pose, p, &image));
      out.segment<2>(2 * static_cast<Eigen::Index>(i)) = image / s.sigma_normalised;
    }
    return out;
  };
  Eigen::MatrixXd J(2 * static_cast<Eigen::Index>(g->observations.size()), size);
  constexpr double kStep = 1e-5;
  for (Eigen::Index k = 0; k < size; ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(size, k);
    J.col(k) = (images(step) - images(-step)) / (2.0 * kStep);
  }
  // Constraints as rows of large weight: centroid, extent, first attitude.
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(7, size);
  H.block<3, 3>(4, 0).setIdentity();
  for (Eigen::Index i = 0; i < points; ++i) {
    H.block<3, 3>(0, 6 * frames + 3 * i).setIdentity();
    H.block<1, 3>(3, 6 * frames + 3 * i) = g->points_T[static_cast<std::size_t>(i)].transpose();
  }
  // Minimum-variance under exact constraints: invert on their null space.
  const Eigen::MatrixXd N = Eigen::FullPivLU<Eigen::MatrixXd>(H).kernel();
  const Eigen::MatrixXd JN = J * N;
  return (N * (JN.transpose() * JN).inverse() * N.transpose())
      .bottomRightCorner(3 * points, 3 * points);
}

TEST(InitialAdjustment, PointCovariances_EqualTheDenseOnesUnderTheSameGauge) {
  InitialGeometry g =
      make_initial_geometry({.points = 14, .frames = 4, .extent_over_range = 0.1}, 23);
  ASSERT_TRUE(normalise_gauge(g.view()));
  std::vector<Eigen::Matrix3d> covariances(g.points_T.size());
  const auto w = workspace();
  ASSERT_TRUE(initial_point_covariances(g.observations, g.view(), {}, covariances, w.get()));
  const Eigen::MatrixXd dense = dense_point_covariance(&g);
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(3 * i);
    const Eigen::Matrix3d expected = dense.block<3, 3>(k, k);
    EXPECT_LT((covariances[i] - expected).norm(), 1e-3 * expected.norm()) << i;
  }
}

}  // namespace
}  // namespace polhode::initial_adjustment_test
