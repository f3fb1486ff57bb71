// Metres from a length that was picked in a picture: read when the map begins, read anew as it
// grows, gone with the map whose unit it was; or from a dimension of the shape.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "bench.hpp"
#include "packets_of.hpp"
#include "pipeline/reset.hpp"
#include "pipeline/results.hpp"
#include "pipeline/smooth.hpp"
#include "state_of.hpp"

namespace polhode::scale_test {
namespace {

using namespace bench;

constexpr int kFrames = 24;
constexpr std::array<std::array<double, 2>, 2> kEnds_px{{{120.0, 105.0}, {200.0, 130.0}}};

/// Where a picture point lies on the ball of radius 1.
Eigen::Vector3d on_ball(const std::array<double, 2>& px, const Pose& pose) {
  const Eigen::Vector3d ray =
      Eigen::Vector3d((px[0] - 160.0) / kFocal_px, (px[1] - 120.0) / kFocal_px, 1.0).normalized();
  const double along = ray.dot(pose.p_CT);
  return (along - std::sqrt(along * along - pose.p_CT.squaredNorm() + 1.0)) * ray;
}

/// The two ends are picked in the first picture, and told of beforehand.
Parameters with_length() {
  Parameters p = parameters();
  p.scale = {.known_length_m =
                 (on_ball(kEnds_px[1], turning(0)) - on_ball(kEnds_px[0], turning(0))).norm(),
             .points_px = kEnds_px,
             .frame_timestamp_ns = Bench::kSecond_ns};
  return p;
}

/// Depths of the landmarks seen last, in metres by the run's scale, over the true ones: the median.
double depth_ratio(const Component::State& s, int frame) {
  std::vector<double> ratios;
  for (const LandmarkMatch& match : s.mapping.localised.matches) {
    const Landmark& landmark = s.mapping.map.landmarks[match.landmark.index()];
    if (match.inlier && landmark.used) {
      const double depth_mu = s.mapping.localised.absolute.pose.to_camera(landmark.p_T).z();
      ratios.push_back(s.scale.metres_per_mu * depth_mu /
                       on_ball({match.u_px, match.v_px}, turning(frame)).z());
    }
  }
  std::nth_element(
      ratios.begin(), ratios.begin() + static_cast<long>(ratios.size() / 2), ratios.end());
  return ratios[ratios.size() / 2];
}

// verifies: SHP-08
TEST(KnownLength, GivesMetres_AndIsReadAnewAsTheMapGrows) {
  const std::vector<Picture> pictures = images_of_turning(kFrames);
  Bench b(with_length());
  std::vector<double> told;
  for (const Picture& picture : pictures) {
    const StepOutput& out = b.show(picture);
    for (const auto& event : packets_of<bus::EventPacket>(out)) {
      if (event.id == static_cast<std::uint16_t>(bus::EventId::kScaleKnown) &&
          event.value[0] > 0.0) {
        told.push_back(event.value[0]);
      }
    }
    EXPECT_EQ(out.motion.scale_known, out.motion.pose_valid) << "from the first pose on";
  }
  EXPECT_GE(told.size(), 2U);
  const Component::State& s = state_of(*b.component);
  EXPECT_EQ(s.scale.metres_per_mu, told.back());
  // The ends are exact; by a pixel each the reading itself says that it may be off by 2 %.
  EXPECT_NEAR(depth_ratio(s, kFrames - 1), 1.0, 3.0 * s.scale.relative_sigma);
  EXPECT_LT(s.scale.relative_sigma, 0.03);
}

TEST(KnownLength, IsForgotten_WithWhatItWasMeasuredOn) {
  const std::vector<Picture> pictures = images_of_turning(kFrames);
  Bench b(with_length());
  for (const Picture& picture : pictures) {
    (void)b.show(picture);
  }
  Component::State& s = state_of(*b.component);
  ASSERT_TRUE(s.scale.known);
  reset_target(&s);
  EXPECT_FALSE(s.scale.known);
  EXPECT_EQ(s.scale.metres_per_mu, 1.0);
  EXPECT_TRUE(s.scale.readings.empty());
}

TEST(KnownLength, OfAFrameThatIsNotThere_LeavesMapUnits) {
  const std::vector<Picture> pictures = images_of_turning(kFrames);
  Parameters p = with_length();
  p.scale.frame_timestamp_ns = 1;
  Bench b(p);
  for (const Picture& picture : pictures) {
    EXPECT_FALSE(b.show(picture).motion.scale_known);
  }
  EXPECT_FALSE(read_scale_in_keyframe(b.component));
}

// verifies: SHP-10
TEST(KnownDiameter, IsReadOfAShape_OnceTheBodyHasTurnedByARightAngle) {
  Parameters p = parameters();
  p.scale.known_diameter_m = 1.9;
  Bench b(p);
  Component::State& s = state_of(*b.component);
  Shape shape;
  shape.cylinder = Cylinder{.radius = 0.5, .sigma_radius = 0.01};
  s.jobs.shape_work.outcome = shape;
  const auto come_back = [&] {
    s.jobs.shape = {.work = &s.jobs.shape_work, .done = true};
    close_jobs(&s);
  };
  s.mapping.drift.turn_rad = 0.5;
  come_back();
  EXPECT_FALSE(s.scale.known) << "seen from one side, a young map is bent";
  s.mapping.drift.turn_rad = 1.6;
  come_back();
  ASSERT_TRUE(s.scale.known);
  EXPECT_NEAR(s.scale.metres_per_mu, 1.9, 1e-12);
  EXPECT_NEAR(s.scale.relative_sigma, 0.02, 1e-3);
}

TEST(KnownEdge, IsNotConfirmedByItsOwnEarlierReading) {
  Parameters p = parameters();
  p.scale.known_edge_m = 2.0;
  Bench b(p);
  const Component::State& s = state_of(*b.component);
  Shape shape;
  shape.box = Box{};
  shape.dimension_basis.fill(DimensionBasis::kSurfaces);
  shape.sigma_dimensions.setConstant(0.01);
  shape.dimensions = {1.0, 0.8, 0.6};
  ASSERT_TRUE(read_scale_in_shape(shape, b.component));
  EXPECT_NEAR(s.scale.metres_per_mu, 2.0, 1e-12);
  shape.dimensions = {1.0, 1.6, 0.6};  // another side is seen whole now, and is the longest
  ASSERT_TRUE(read_scale_in_shape(shape, b.component));
  EXPECT_NEAR(s.scale.metres_per_mu, 1.25, 1e-12);
}

}  // namespace
}  // namespace polhode::scale_test
