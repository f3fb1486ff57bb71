#include "shape/scale_state.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace polhode::scale_state_test {
namespace {

const CameraModel kCamera{
    .width_px = 640, .height_px = 480, .fu_px = 800, .fv_px = 800, .cu_px = 319.5, .cv_px = 239.5};

/// A wall of landmarks two map units before the camera, on which 80 px are 0.2 map units.
class ScaleReadingsOfAWall : public ::testing::Test {
 protected:
  ScaleReadingsOfAWall() {
    for (int x = -10; x <= 10; ++x) {
      for (int y = -10; y <= 10; ++y) {
        landmarks_T_.push_back({0.02 * x, 0.02 * y, 0.0});
      }
    }
    options_.points_px = {{{279.5, 239.5}, {359.5, 239.5}}};
  }
  ScaleChange read(std::uint32_t next_keyframe = 6) {
    const ScaleView view{.pose = {.R_CT = Eigen::Matrix3d::Identity(), .p_CT = {0.0, 0.0, 2.0}},
                         .landmarks_T = landmarks_T_};
    return read_scale_in(view, options_, kCamera, next_keyframe, &scale_);
  }
  std::vector<Eigen::Vector3d> landmarks_T_;
  ScaleOptions options_;
  ScaleState scale_;
};

TEST_F(ScaleReadingsOfAWall, NothingIsReadWhereNothingIsNamed) {
  EXPECT_FALSE(names_frame(options_));
  EXPECT_FALSE(read().read);
  EXPECT_FALSE(scale_.known);
}

TEST_F(ScaleReadingsOfAWall, ALengthGivesMetres) {
  options_.known_length_m = 1.0;
  EXPECT_TRUE(frame_reading_is_due(options_, 6, scale_));
  EXPECT_TRUE(read().read);
  EXPECT_TRUE(scale_.known);
  EXPECT_NEAR(scale_.metres_per_mu, 5.0, 0.05);
}

TEST_F(ScaleReadingsOfAWall, ItIsDueAgainOnceTheMapHasGrownByHalf) {
  options_.known_length_m = 1.0;
  (void)read(10);
  EXPECT_FALSE(frame_reading_is_due(options_, 10, scale_));
  EXPECT_FALSE(frame_reading_is_due(options_, 14, scale_));
  EXPECT_TRUE(frame_reading_is_due(options_, 15, scale_));
}

TEST_F(ScaleReadingsOfAWall, AContradictionBeginsOnce_AndLeavesTheScaleUnknown) {
  options_.known_length_m = 1.0;
  (void)read();
  options_.range_m = 30.0;  // 2 map units are 10 m by the length
  options_.range_sigma_m = 0.01;
  EXPECT_TRUE(read().contradiction_began);
  EXPECT_TRUE(scale_.contradiction);
  EXPECT_FALSE(scale_.known);
  EXPECT_FALSE(read().contradiction_began) << "it has begun";
}

TEST_F(ScaleReadingsOfAWall, WhatIsNoLongerNamedIsReplaced) {
  options_.known_length_m = 1.0;
  (void)read();
  options_.known_length_m = 0.0;
  options_.range_m = 4.0;
  options_.range_sigma_m = 0.01;
  EXPECT_TRUE(read().read);
  EXPECT_FALSE(scale_.contradiction);
  EXPECT_NEAR(scale_.metres_per_mu, 2.0, 0.05);
  EXPECT_EQ(scale_.readings.size(), 1U);
}

TEST_F(ScaleReadingsOfAWall, AShapeWithoutTheNamedPartGivesNothing) {
  options_.known_diameter_m = 1.0;
  options_.known_edge_m = 2.0;
  EXPECT_FALSE(read_scale_of(Shape{}, options_, &scale_).read);
}

}  // namespace
}  // namespace polhode::scale_state_test
