#include "initialisation/collect.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "base/rng.hpp"

namespace polhode {
namespace {

constexpr double kRatioMax = 0.8;
constexpr int kPoints = 60;
const CameraModel kCamera{
    .width_px = 320, .height_px = 240, .fu_px = 500, .fv_px = 500, .cu_px = 159.5, .cv_px = 119.5};

/// Points of a ball of radius 40 px whose near side is turned by an angle and shifted, each with a
/// descriptor of its own.
std::unique_ptr<Features> ball(double turn_rad, double shift_px = 0.0, int points = kPoints) {
  auto features = std::make_unique<Features>();
  for (int i = 0; i < points; ++i) {
    const double height = 2.0 * (i + 0.5) / points - 1.0;
    const double angle_rad = 2.4 * i + turn_rad;
    const double across = std::sqrt(1.0 - height * height);
    Feature f{};
    f.u_px =
        static_cast<float>(160.0 + shift_px + 40.0 * across * std::sin(0.3 * angle_rad + turn_rad));
    f.v_px = static_cast<float>(120.0 + 40.0 * height);
    f.normalised = undistort(kCamera, {static_cast<double>(f.u_px), static_cast<double>(f.v_px)});
    f.sigma_px = 0.5F;
    for (std::size_t k = 0; k < f.descriptor.size(); ++k) {
      f.descriptor[k] = static_cast<std::uint8_t>(
          (static_cast<std::size_t>(i) * 37 + k * (static_cast<std::size_t>(i) + 11)) % 251);
    }
    (void)features->push_back(f);
  }
  return features;
}

class CollectFrame : public ::testing::Test {
 protected:
  Collected show(const Features& features) {
    ++second_;
    return collect_frame(
        {.frame = second_, .timestamp_ns = second_ * 1'000'000'000LL, .features = &features},
        kRatioMax,
        state_.get());
  }
  std::unique_ptr<InitialisationState> state_ = std::make_unique<InitialisationState>();
  std::uint32_t second_ = 0;
};

TEST_F(CollectFrame, KeepsTheFirstFrame) {
  EXPECT_TRUE(show(*ball(0.0)).kept);
  EXPECT_EQ(state_->tracks.frames.size(), 1U);
}

TEST_F(CollectFrame, KeepsNoFrameWithTooFewFeatures) {
  EXPECT_FALSE(show(*ball(0.0, 0.0, 11)).kept);
  EXPECT_TRUE(state_->tracks.frames.empty());
}

TEST_F(CollectFrame, KeepsNoFrameThatShowsTheSameAgain) {
  (void)show(*ball(0.0));
  EXPECT_FALSE(show(*ball(0.0)).kept);
  EXPECT_FALSE(show(*ball(0.0, 3.0)).kept)
      << "a shift of a tenth of the radius tells nothing of depth";
  EXPECT_EQ(state_->tracks.frames.size(), 1U);
}

TEST_F(CollectFrame, KeepsAFrameOfABodyThatHasTurned) {
  (void)show(*ball(0.0));
  EXPECT_TRUE(show(*ball(0.2)).kept);
  EXPECT_EQ(state_->tracks.frames.size(), 2U);
}

TEST_F(CollectFrame, KeepsAFrameOfABodyThatHasMovedFar) {
  (void)show(*ball(0.0));
  EXPECT_TRUE(show(*ball(0.0, 30.0)).kept);
}

TEST_F(CollectFrame, TheProblemHasEveryFrameWithItsTimeAndEveryTrack) {
  (void)show(*ball(0.0));
  (void)show(*ball(0.2));
  (void)show(*ball(0.4));
  const auto job = std::make_unique<StartJob>();
  pose_problem(kCamera, {}, 7, state_.get(), job.get());
  ASSERT_EQ(job->frame_count, 3U);
  EXPECT_EQ(job->times_s[0], 0.0);
  EXPECT_EQ(job->times_s[2], 2.0);
  EXPECT_EQ(job->seed, 7U);
  ASSERT_EQ(job->track_count, state_->tracks.tracks.size());
  ASSERT_GT(job->track_count, 0U);
  for (std::size_t t = 0; t < job->track_count; ++t) {
    for (const auto& observation : job->tracks[t].observations) {
      EXPECT_DOUBLE_EQ(observation.sigma_normalised, 0.5 / kCamera.focal_px());
    }
  }
}

TEST_F(CollectFrame, ASkippedSelectionCommitsToNothing) {
  const auto job = std::make_unique<StartJob>();
  job->outcome.decision = StartDecision::kCommit;
  job->outcome.crowded = true;
  skip_start(job.get());
  EXPECT_EQ(job->outcome.decision, StartDecision::kTooFewTracks);
  EXPECT_FALSE(job->outcome.crowded);
}

}  // namespace
}  // namespace polhode
