#include "camera/lens_warnings.hpp"

#include <gtest/gtest.h>

namespace polhode::platform::lens_warnings_test {
namespace {

CameraParameters camera(double fu, double fv, double cu, double cv) {
  return {.width_px = 640, .height_px = 480, .fu_px = fu, .fv_px = fv, .cu_px = cu, .cv_px = cv};
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(LensWarnings, UsualCamerasRaiseNone) {
  EXPECT_TRUE(lens_warnings(camera(889, 889, 319.5, 239.5)).empty());
  EXPECT_TRUE(lens_warnings(camera(3310.4, 3325.5, 316.73, 200.55)).empty());  // dinonut
  EXPECT_TRUE(lens_warnings(camera(348, 348, 319.5, 239.5)).empty());
  CameraParameters euroc = camera(458.654, 457.296, 367.215, 248.375);
  euroc.width_px = 752;
  euroc.k1 = -0.28340811;
  euroc.k2 = 0.07395907;
  EXPECT_TRUE(lens_warnings(euroc).empty());
  EXPECT_EQ(wrong_order(euroc), "");
}

TEST(LensWarnings, IntrinsicsOfALargerImageAreNamed) {
  const auto warnings = lens_warnings(camera(1777.8, 1777.8, 639.5, 479.5));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(holds(warnings[0], "intrinsics: the principal point (639.5, 479.5) is 50 %"))
      << warnings[0];
  EXPECT_TRUE(holds(warnings[0], "a picture 2 times as large")) << warnings[0];
}

TEST(LensWarnings, PixelsThatAreNoSquares) {
  const auto warnings = lens_warnings(camera(889, 500, 319.5, 239.5));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(holds(warnings[0], "differ by a factor of 1.78")) << warnings[0];
  EXPECT_TRUE(lens_warnings(camera(500, 889, 319.5, 239.5), 16.0 / 9.0).empty());
  EXPECT_TRUE(holds(lens_warnings(camera(889, 889, 319.5, 239.5), 16.0 / 9.0).at(0),
                    "differ by a factor of 1.78 beside pixel_aspect"));
}

TEST(LensWarnings, FieldsOfViewThatNoPinholeHas) {
  EXPECT_TRUE(holds(lens_warnings(camera(100, 100, 319.5, 239.5)).at(0), "145 deg"));
  EXPECT_EQ(lens_warnings(camera(9e5, 9e5, 319.5, 239.5)).size(), 1U);
}

TEST(LensWarnings, ADistortionThatFoldsWithinTheImage) {
  CameraParameters folded = camera(500, 500, 319.5, 239.5);
  folded.k1 = -0.8;
  const auto warnings = lens_warnings(folded);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(holds(warnings[0], "fold the picture back at 215 px")) << warnings[0];
  folded.k1 = -0.2;  // beyond the corner
  EXPECT_TRUE(lens_warnings(folded).empty());
}

TEST(LensWarnings, AnotherOrderIsRefused_ACutOutImageIsNot) {
  EXPECT_TRUE(holds(wrong_order(camera(888.9, 319.5, 888.9, 239.5)), "look like fu, cu, fv, cv"));
  EXPECT_TRUE(holds(wrong_order(camera(319.5, 239.5, 888.9, 888.9)), "look like cu, cv, fu, fv"));
  EXPECT_EQ(wrong_order(camera(888.9, 888.9, 319.5, 239.5)), "");
  EXPECT_EQ(wrong_order(camera(1800, 1800, 900, -50)), "");
  EXPECT_EQ(lens_warnings(camera(1800, 1800, 900, -50)).size(), 1U);
}

}  // namespace
}  // namespace polhode::platform::lens_warnings_test
