#include "mask/plane_motion.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "base/rng.hpp"

namespace polhode::plane_motion_test {
namespace {

const cv::Matx33d kMotion(1.02, -0.03, 4.0, 0.02, 0.99, -7.0, 3E-5, -2E-5, 1.0);

struct Pairs {
  std::vector<cv::Point2f> from;
  std::vector<cv::Point2f> to;

  void add(int count, bool agreeing, std::uint64_t seed) {
    Rng rng(seed, 0);
    for (int i = 0; i < count; ++i) {
      const cv::Point2f p(static_cast<float>(640.0 * rng.uniform()),
                          static_cast<float>(360.0 * rng.uniform()));
      const cv::Point2f noise(static_cast<float>(0.2 * rng.normal()),
                              static_cast<float>(0.2 * rng.normal()));
      const cv::Point2f stray(static_cast<float>(30.0 * rng.uniform() + 5.0),
                              static_cast<float>(30.0 * rng.uniform() + 5.0));
      from.push_back(p);
      to.push_back(moved(kMotion, p) + (agreeing ? noise : stray));
    }
  }
};

TEST(FitPlaneMotion, FindsTheMotion_AmongAsManyStrays) {
  Pairs pairs;
  pairs.add(120, true, 1);
  pairs.add(100, false, 2);
  cv::Matx33d motion;
  std::vector<std::uint8_t> agrees;
  ASSERT_TRUE(fit_plane_motion(pairs.from, pairs.to, 1.0, &motion, &agrees));
  for (const cv::Point2f& p : {cv::Point2f(20, 20), cv::Point2f(600, 30), cv::Point2f(320, 340)}) {
    EXPECT_LT(cv::norm(moved(motion, p) - moved(kMotion, p)), 0.3);
  }
  int wrong = 0;
  for (std::size_t i = 0; i < agrees.size(); ++i) {
    wrong += (agrees[i] != 0) != (i < 120) ? 1 : 0;
  }
  EXPECT_LE(wrong, 2);
}

TEST(FitPlaneMotion, IsTheSame_WhenFittedTwice) {
  Pairs pairs;
  pairs.add(60, true, 3);
  pairs.add(60, false, 4);
  cv::Matx33d a;
  cv::Matx33d b;
  std::vector<std::uint8_t> agrees;
  ASSERT_TRUE(fit_plane_motion(pairs.from, pairs.to, 1.0, &a, &agrees));
  ASSERT_TRUE(fit_plane_motion(pairs.from, pairs.to, 1.0, &b, &agrees));
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0.0);
}

TEST(FitPlaneMotion, FindsNone_AmongStrays_OrTooFew_OrPointsInOnePlace) {
  Pairs strays;
  Rng rng(5, 0);
  for (int i = 0; i < 60; ++i) {
    strays.from.emplace_back(static_cast<float>(640.0 * rng.uniform()),
                             static_cast<float>(360.0 * rng.uniform()));
    strays.to.emplace_back(static_cast<float>(640.0 * rng.uniform()),
                           static_cast<float>(360.0 * rng.uniform()));
  }
  cv::Matx33d motion;
  std::vector<std::uint8_t> agrees;
  EXPECT_FALSE(fit_plane_motion(strays.from, strays.to, 1.0, &motion, &agrees));
  Pairs few;
  few.add(5, true, 6);
  EXPECT_FALSE(fit_plane_motion(few.from, few.to, 1.0, &motion, &agrees));
  const std::vector<cv::Point2f> one_place(20, cv::Point2f(100, 100));
  (void)fit_plane_motion(
      one_place, one_place, 1.0, &motion, &agrees);  // returns, whatever the result
}

}  // namespace
}  // namespace polhode::plane_motion_test
