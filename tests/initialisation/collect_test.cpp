#include "initialisation/collect.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "base/rng.hpp"
#include "geometry/image_motion.hpp"

namespace polhode::collect_test {
namespace {

constexpr double kRatioMax = 0.8;
constexpr int kPoints = 60;
const CameraModel kCamera{
    .width_px = 320, .height_px = 240, .fu_px = 500, .fv_px = 500, .cu_px = 159.5, .cv_px = 119.5};

/// Points of a ball of radius 40 px whose near face is turned by an angle and shifted, each with a
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
  Collected show(const Features& features, const CameraModel& camera = kCamera) {
    ++second_;
    return collect_frame(
        {.frame = second_, .timestamp_ns = second_ * 1'000'000'000LL, .features = &features},
        camera,
        kRatioMax,
        state_.get(),
        &resting_);
  }
  std::unique_ptr<InitialisationState> state_ = std::make_unique<InitialisationState>();
  RestingPlaces resting_;
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
  const auto job = std::make_unique<InitialisationJob>();
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

TEST_F(CollectFrame, TheProblemHasTheImageOfEachFrameAboutItsFeatures) {
  const auto job = std::make_unique<InitialisationJob>();
  for (int frame = 0; frame < 3; ++frame) {
    const auto seen = ball(0.2 * frame);
    (void)show(*seen);
    const cv::Mat gray(
        kCamera.height_px, kCamera.width_px, CV_8UC1, cv::Scalar(10.0 * (frame + 1)));
    keep_crop(gray, second_, seen->view(), &job->images.crops);
  }
  pose_problem(kCamera, {}, 7, state_.get(), job.get());
  for (int frame = 0; frame < 3; ++frame) {
    const Crop* const crop = job->images.crop(static_cast<std::size_t>(frame));
    ASSERT_NE(crop, nullptr);
    EXPECT_GT(crop->width, 80);
    EXPECT_LT(crop->width, 120);
    EXPECT_EQ(crop->levels[0], 10 * (frame + 1));
  }
  for (std::size_t t = 0; t < job->track_count; ++t) {
    for (const InitialObservation& o : job->tracks[t].observations) {
      const auto frame = static_cast<std::size_t>(o.frame);
      ASSERT_TRUE(job->images.places[t].has(frame));
      const Eigen::Vector2d px = job->images.places[t].px[frame].cast<double>();
      EXPECT_LT((undistort(kCamera, px) - o.normalised).norm() * kCamera.focal_px(), 1e-4);
    }
  }
}

TEST_F(CollectFrame, BringsRowsOfARollingShutterToTheFramesTime) {
  constexpr double kSpeed_px_s = 40.0;
  CameraModel rolling = kCamera;
  rolling.line_time_s = 2e-3;  // the image in half of the time between frames
  for (int frame = 0; frame < 3; ++frame) {
    auto seen = ball(0.0, kSpeed_px_s * frame);
    for (Feature& f : *seen) {
      f.u_px += static_cast<float>(kSpeed_px_s * row_delay_s(rolling, f.v_px));
      f.normalised = undistort(rolling, {f.u_px, f.v_px});
    }
    ASSERT_TRUE(show(*seen, rolling).kept);
  }
  for (int frame = 0; frame < 3; ++frame) {
    const auto right = ball(0.0, kSpeed_px_s * frame);
    const Features& kept = state_->tracks.frames[static_cast<std::size_t>(frame)].features;
    ASSERT_EQ(kept.size(), right->size());
    for (std::size_t i = 0; i < kept.size(); ++i) {
      EXPECT_LT((kept[i].normalised - (*right)[i].normalised).norm() * rolling.focal_px(), 1e-3);
    }
  }
}

TEST_F(CollectFrame, CountsTheFramesThatItHasKeptSinceTheLastProblem) {
  (void)show(*ball(0.0));
  (void)show(*ball(0.2));
  (void)show(*ball(0.2));  // not kept
  EXPECT_EQ(state_->since_asked, 2);
  const auto job = std::make_unique<InitialisationJob>();
  pose_problem(kCamera, {}, 7, state_.get(), job.get());
  EXPECT_EQ(state_->since_asked, 0);
}

TEST_F(CollectFrame, ASkippedSelectionCommitsToNothing) {
  const auto job = std::make_unique<InitialisationJob>();
  job->outcome.decision = InitialDecision::kCommit;
  job->outcome.crowded = true;
  skip_initialisation(job.get());
  EXPECT_EQ(job->outcome.decision, InitialDecision::kTooFewTracks);
  EXPECT_FALSE(job->outcome.crowded);
}

/// Frames a second apart, and tracks over them.
class PoseProblem : public ::testing::Test {
 protected:
  void add_frames(int count) {
    for (int f = 0; f < count; ++f) {
      const std::size_t at = state_->tracks.frames.size();
      state_->tracks.frames.resize(at + 1);
      CollectedFrame& frame = state_->tracks.frames[at];
      frame.timestamp_ns = static_cast<std::int64_t>(at) * 1'000'000'000;
      frame.features.resize(1);
      frame.features[0].sigma_px = 0.5F;
      // The frame's number: it shows which frame an observation is from.
      frame.features[0].normalised = {static_cast<double>(at), 0.0};
    }
  }
  /// Tracks with a point in each of the frames first .. last.
  void add_tracks(int count, int first, int last, std::int32_t distance2 = 0) {
    for (int i = 0; i < count; ++i) {
      Track track;
      for (int f = first; f <= last; ++f) {
        (void)track.points.push_back({.frame = f, .feature = 0, .distance2 = distance2});
      }
      ASSERT_TRUE(state_->tracks.tracks.push_back(track));
    }
  }
  const InitialisationJob& pose(int frames_min = 5) {
    pose_problem(kCamera, {.frames_min = frames_min}, 7, state_.get(), job_.get());
    return *job_;
  }
  std::unique_ptr<InitialisationState> state_ = std::make_unique<InitialisationState>();
  std::unique_ptr<InitialisationJob> job_ = std::make_unique<InitialisationJob>();
};

TEST_F(PoseProblem, IsOfTheNewestFramesThatEnoughTracksSpan_AndOfAllInTurns) {
  add_frames(12);
  add_tracks(50, 5, 11);
  add_tracks(60, 9, 11);
  for (int turn = 0; turn < 2; ++turn) {
    EXPECT_EQ(pose().first_frame, 4U) << "an end is two frames wide";
    EXPECT_EQ(job_->frame_count, 8U);
    EXPECT_EQ(job_->times_s[0], 0.0);
    EXPECT_EQ(job_->times_s[7], 7.0);
    EXPECT_EQ(pose().first_frame, 0U);
    EXPECT_EQ(job_->frame_count, 12U);
    EXPECT_EQ(job_->times_s[11], 11.0);
  }
}

TEST_F(PoseProblem, CountsItsFramesFromItsFirst) {
  add_frames(12);
  add_tracks(50, 5, 11);
  add_tracks(1, 0, 11);
  add_tracks(1, 0, 3);
  ASSERT_EQ(pose().first_frame, 4U);
  ASSERT_EQ(job_->track_count, 52U) << "as in the table, those without an image too";
  EXPECT_EQ(job_->tracks[0].observations.size(), 7U);
  EXPECT_EQ(job_->tracks[0].observations[0].frame, 1);
  EXPECT_EQ(job_->tracks[50].observations.size(), 8U);
  EXPECT_EQ(job_->tracks[51].observations.size(), 0U);
  for (std::size_t t = 0; t < job_->track_count; ++t) {
    for (const InitialObservation& o : job_->tracks[t].observations) {
      EXPECT_EQ(o.normalised.x(), o.frame + 4.0);
    }
  }
}

TEST_F(PoseProblem, IsSpannedByAThirdOfManyTracks) {
  add_frames(12);
  add_tracks(50, 2, 11);  // enough, but a fifth of all
  add_tracks(40, 6, 11);  // with these more than a third
  add_tracks(160, 9, 11);
  EXPECT_EQ(pose().first_frame, 5U);
}

TEST_F(PoseProblem, IsNotSpannedByTracksThatHaveEnded) {
  add_frames(12);
  add_tracks(200, 0, 9);
  add_tracks(50, 5, 10);  // missed in the last frame, and may come again
  EXPECT_EQ(pose().first_frame, 4U);
}

TEST_F(PoseProblem, HasTheLeastNumberOfFrames_WhereTooFewTracksSpanMore) {
  add_frames(12);
  add_tracks(39, 0, 11);
  EXPECT_EQ(pose().first_frame, 7U);
  EXPECT_EQ(job_->frame_count, 5U);
  EXPECT_EQ(pose().first_frame, 0U);
  EXPECT_EQ(pose(8).first_frame, 4U);
}

TEST_F(PoseProblem, IsAlwaysOfAllFrames_WhereTheTracksSpanThem) {
  add_frames(12);
  add_tracks(50, 0, 11);
  for (int turn = 0; turn < 3; ++turn) {
    EXPECT_EQ(pose().first_frame, 0U);
    EXPECT_EQ(job_->frame_count, 12U);
  }
}

TEST_F(PoseProblem, SaysThatAFeatureIsLessSure_TheMoreItsLookHasChanged) {
  add_frames(5);
  add_tracks(1, 0, 4, 100 * 100);
  add_tracks(1, 0, 4, 200 * 200);
  add_tracks(1, 0, 4, 300 * 300);
  const double sigma = 0.5 / kCamera.focal_px();
  (void)pose();
  const double factor[] = {1.0, 1.0, 2.25};
  for (std::size_t t = 0; t < 3; ++t) {
    for (const InitialObservation& o : job_->tracks[t].observations) {
      EXPECT_DOUBLE_EQ(o.sigma_normalised, factor[t] * sigma) << t;
    }
  }
}

TEST_F(PoseProblem, IsWantedWithEveryFrame_AndMoreSeldomWithMany) {
  const InitialOptions options{.frames_min = 5};
  const auto wanted_after = [&] {
    int since = 0;
    for (state_->since_asked = 0; !wants_selection(options, *state_); ++state_->since_asked) {
      ++since;
      if (since > 100) break;
    }
    return since;
  };
  add_frames(4);
  state_->since_asked = 4;
  EXPECT_FALSE(wants_selection(options, *state_)) << "too few frames";
  add_frames(1);
  EXPECT_EQ(wanted_after(), 1);
  add_frames(6);
  EXPECT_EQ(wanted_after(), 1);
  add_frames(9);
  EXPECT_EQ(wanted_after(), 2);
  add_frames(12);
  EXPECT_EQ(wanted_after(), 3);
}

TEST_F(PoseProblem, BeginsAfreshAfterClear) {
  add_frames(12);
  add_tracks(50, 5, 11);
  ASSERT_EQ(pose().first_frame, 4U);
  state_->since_asked = 3;
  clear(state_.get());
  EXPECT_TRUE(state_->tracks.frames.empty());
  EXPECT_EQ(state_->since_asked, 0);
  add_frames(12);
  add_tracks(50, 5, 11);
  EXPECT_EQ(pose().first_frame, 4U) << "the turn is the short problem's";
}

}  // namespace
}  // namespace polhode::collect_test
