#include "map/follow.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "synthetic_map.hpp"

namespace polhode::follow_test {
namespace {

using namespace synthetic;

constexpr double kDepth_mu = 10.0;

/// A sum of waves, sampled exactly at any shift: what a textured panel shows that moves parallel to
/// the image.
cv::Mat texture(std::uint64_t seed, double shift_u_px, double shift_v_px) {
  const CameraModel model = camera();
  cv::Mat sum(model.height_px, model.width_px, CV_64FC1);
  sum.setTo(128.0);
  Rng rng(seed, 141);
  for (int i = 0; i < 30; ++i) {
    const double frequency = 2.0 * std::numbers::pi / (8.0 * std::pow(7.0, rng.uniform()));
    const double direction = 2.0 * std::numbers::pi * rng.uniform();
    const double fu = frequency * std::cos(direction);
    const double fv = frequency * std::sin(direction);
    const double phase = 2.0 * std::numbers::pi * rng.uniform();
    for (int v = 0; v < model.height_px; ++v) {
      auto* row = sum.ptr<double>(v);
      for (int u = 0; u < model.width_px; ++u) {
        row[u] += 14.0 * std::cos(fu * (u - shift_u_px) + fv * (v - shift_v_px) + phase);
      }
    }
  }
  cv::Mat gray;
  sum.convertTo(gray, CV_8UC1);
  return gray;
}

Pose moved(double u_px, double v_px) {
  const double per_px = kDepth_mu / camera().focal_px();
  return {.p_CT = {u_px * per_px, v_px * per_px, kDepth_mu}};
}

/// Landmarks on the panel, and the reference frame in which they were seen.
struct Bench {
  std::unique_ptr<Map> map = std::make_unique<Map>();
  std::unique_ptr<FlowReference> reference = std::make_unique<FlowReference>();
  std::unique_ptr<Features> features = std::make_unique<Features>();
  std::unique_ptr<LocaliseScratch> scratch = std::make_unique<LocaliseScratch>();
  std::unique_ptr<LocalisedFrame> out = std::make_unique<LocalisedFrame>();
  CameraModel model = camera();
  LocaliseOptions options;

  Bench() {
    reference->valid = true;
    reference->pose = moved(0.0, 0.0);
    build_pyramid(texture(1, 0.0, 0.0), &reference->pyramid);
    for (int v = 80; v <= 400; v += 40) {
      for (int u = 80; u <= 560; u += 40) {
        const LandmarkId id = add_landmark(map.get());
        Landmark& landmark = map->landmarks[id.index()];
        const Eigen::Vector2d n =
            undistort(model, {static_cast<double>(u), static_cast<double>(v)});
        landmark.p_T = kDepth_mu * Eigen::Vector3d(n.x(), n.y(), 0.0);
        landmark.normal_T = -Eigen::Vector3d::UnitZ();
        landmark.observations = 5;
        (void)reference->points.push_back({.landmark = id,
                                           .feature = 3,
                                           .u_px = static_cast<float>(u),
                                           .v_px = static_cast<float>(v),
                                           .normalised = n,
                                           .sigma_px = 0.3,
                                           .inlier = true});
      }
    }
  }

  Result<bool> follow(const cv::Mat& image, const Pose& predicted) {
    const LocaliseInput input{.map = map.get(),
                              .features = features.get(),
                              .camera = &model,
                              .options = &options,
                              .seed = 1};
    Pyramid pyramid;
    build_pyramid(image, &pyramid);
    const TrackOptions flow_options;
    return localise_by_flow(
        input, {reference.get(), &pyramid, &flow_options}, predicted, scratch.get(), out.get());
  }
};

TEST(PredictedMotion, IsTheMotionOfTheImage) {
  const Bench b;
  EXPECT_NEAR(predicted_motion_px(*b.reference, moved(0.0, 0.0), *b.map, b.model), 0.0, 1e-9);
  EXPECT_NEAR(predicted_motion_px(*b.reference, moved(3.0, -4.0), *b.map, b.model), 5.0, 1e-6);
}

TEST(PredictedMotion, IsLarge_WhenNothingStaysInView_OrNothingIsKnown) {
  Bench b;
  EXPECT_GT(predicted_motion_px(*b.reference, {.p_CT = {0.0, 0.0, -10.0}}, *b.map, b.model), 1e4);
  b.reference->points.clear();
  EXPECT_GT(predicted_motion_px(*b.reference, moved(0.0, 0.0), *b.map, b.model), 1e4);
}

TEST(LocaliseByFlow, FindsThePose_OfAnImageThatHasMoved) {
  Bench b;
  const Pose truth = moved(7.3, -4.6);
  ASSERT_TRUE(b.follow(texture(1, 7.3, -4.6), moved(6.0, -4.0)).ok());
  EXPECT_GT(b.out->absolute.inliers, 100);
  for (const LandmarkMatch& m : b.out->matches) {
    EXPECT_EQ(m.feature, -1) << "found by flow, not by a feature";
    const Eigen::Vector3d& p_T = b.map->landmarks[m.landmark.index()].p_T;
    const Eigen::Vector2d expected = project_px(b.model, truth.to_camera(p_T));
    // Flow is good to 0.05 px in each coordinate, the fit to less.
    EXPECT_LT((Eigen::Vector2d(static_cast<double>(m.u_px), static_cast<double>(m.v_px)) - expected)
                  .norm(),
              0.1);
    EXPECT_LT((project_px(b.model, b.out->absolute.pose.to_camera(p_T)) - expected).norm(), 0.1);
    EXPECT_LT((project_px(b.model, m.normalised) -
               Eigen::Vector2d(static_cast<double>(m.u_px), static_cast<double>(m.v_px)))
                  .norm(),
              1e-6);
  }
}

TEST(LocaliseByFlow, ReturnsAnError_WhenTheImageIsAnotherOne) {
  Bench b;
  EXPECT_FALSE(b.follow(texture(2, 0.0, 0.0), moved(0.0, 0.0)).ok());
}

TEST(LocaliseByFlow, ReturnsAnError_WithoutPoints) {
  Bench b;
  b.reference->points.clear();
  EXPECT_FALSE(b.follow(texture(1, 0.0, 0.0), moved(0.0, 0.0)).ok());
}

TEST(LocaliseByFlow, PassesOverLandmarksThatAreGone) {
  Bench b;
  const std::size_t before = b.reference->points.size();
  for (std::size_t i = 0; i < before; i += 2) {
    remove_landmark(b.reference->points[i].landmark, b.map.get());
  }
  ASSERT_TRUE(b.follow(texture(1, 2.0, 1.0), moved(2.0, 1.0)).ok());
  EXPECT_LE(b.out->matches.size(), before / 2);
  for (const LandmarkMatch& m : b.out->matches) {
    EXPECT_TRUE(b.map->landmarks[m.landmark.index()].used);
  }
}

}  // namespace
}  // namespace polhode::follow_test
