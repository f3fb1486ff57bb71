#include "initialisation/align.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "textured_view.hpp"

namespace polhode::align_test {
namespace {

using textured_view::View;

constexpr std::size_t kFrames = 7;
constexpr double kDetection_px = 0.3;
const CameraModel kCamera{
    .width_px = 120, .height_px = 100, .fu_px = 800, .fv_px = 800, .cu_px = 59.5, .cv_px = 49.5};

/// A textured surface that turns and moves over seven frames, and tracks over it with the noise of
/// detection.
class AlignTracks : public ::testing::Test {
 protected:
  void SetUp() override {
    images_->camera = kCamera;
    for (std::size_t f = 0; f < kFrames; ++f) {
      const double along = static_cast<double>(f) - 3.0;
      views_[f].affine << 1.0 - 0.02 * along, 0.02 * along, -0.03 * along, 1.0 + 0.01 * along;
      views_[f].shift_px = {0.8 * along, -1.1 * along};
      views_[f].gain = 1.0 - 0.05 * along;
      const cv::Mat gray = textured_view::render(views_[f], f + 1);
      const std::vector<Feature> corners = {{.u_px = 0.0F, .v_px = 0.0F},
                                            {.u_px = 119.0F, .v_px = 99.0F}};
      keep_crop(gray, static_cast<std::uint32_t>(f), corners, &images_->crops);
      images_->crop_of[f] = static_cast<std::int8_t>(f);
    }
    for (int y = 0; y < 5; ++y) {
      for (int x = 0; x < 6; ++x) {
        add_track({25.0 + 14.0 * x, 22.0 + 14.0 * y}, (1U << kFrames) - 1U);
      }
    }
  }
  /// Detected in the frames of a mask.
  void add_track(const Eigen::Vector2d& on_surface, std::uint32_t frames) {
    TrackPlaces& places = images_->places[tracks_.size()];
    places.frames = frames;
    InitialTrack track;
    for (std::size_t f = 0; f < kFrames; ++f) {
      if (!places.has(f)) {
        continue;
      }
      const Eigen::Vector2d noise(kDetection_px * rng_.normal(), kDetection_px * rng_.normal());
      places.px[f] = (views_[f].place(on_surface) + noise).cast<float>();
      (void)track.observations.push_back(
          {.frame = static_cast<int>(f),
           .normalised = undistort(kCamera, places.px[f].cast<double>()),
           .sigma_normalised = kDetection_px / kCamera.focal_px()});
    }
    tracks_.push_back(track);
    spots_.push_back(on_surface);
  }
  void align() { align_tracks(*images_, kFrames, tracks_, workspace_.get()); }
  /// RMS of a coordinate of observations from the spot that the middle view shows, px.
  [[nodiscard]] double noise_px() const {
    double squares = 0.0;
    int count = 0;
    for (const InitialTrack& track : tracks_) {
      if (track.observations.empty()) {
        continue;
      }
      const InitialObservation& middle = track.observations[track.observations.size() / 2];
      const View& view = views_[static_cast<std::size_t>(middle.frame)];
      const Eigen::Vector2d spot =
          view.affine.inverse() *
          (project_px(kCamera, Eigen::Vector2d(middle.normalised)) - view.shift_px);
      for (const InitialObservation& o : track.observations) {
        squares += (project_px(kCamera, Eigen::Vector2d(o.normalised)) -
                    views_[static_cast<std::size_t>(o.frame)].place(spot))
                       .squaredNorm();
        count += 2;
      }
    }
    return std::sqrt(squares / count);
  }
  std::array<View, kFrames> views_;
  std::unique_ptr<InitialImages> images_ = std::make_unique<InitialImages>();
  std::unique_ptr<AlignmentWorkspace> workspace_ = std::make_unique<AlignmentWorkspace>();
  std::vector<InitialTrack> tracks_;
  std::vector<Eigen::Vector2d> spots_;
  Rng rng_{5, 0};
};

TEST_F(AlignTracks, TakesThreeQuartersOfTheNoiseAway) {
  ASSERT_GT(noise_px(), kDetection_px);
  align();
  EXPECT_LT(noise_px(), 0.25 * kDetection_px);
  for (const InitialTrack& track : tracks_) {
    EXPECT_GE(track.observations.size(), kFrames - 1);
    for (const InitialObservation& o : track.observations) {
      EXPECT_LT(o.sigma_normalised * kCamera.focal_px(), 0.5 * kDetection_px);
    }
  }
}

TEST_F(AlignTracks, FollowsATrackIntoTheFramesThatMissedIt) {
  add_track({32.0, 29.0}, 0b0010110U);
  align();
  EXPECT_EQ(tracks_.back().observations.size(), kFrames);
  EXPECT_LT(noise_px(), 0.25 * kDetection_px);
}

TEST_F(AlignTracks, TracksOfOneSpotBecomeOne) {
  add_track({32.0, 29.0}, 0b0000111U);
  add_track({32.0, 29.0}, 0b1110000U);
  align();
  const std::size_t first = tracks_.size() - 2;
  EXPECT_EQ(tracks_[first].observations.size() + tracks_[first + 1].observations.size(), kFrames);
}

TEST_F(AlignTracks, DropsAWrongMatch) {
  TrackPlaces& places = images_->places[8];
  places.px[1] += Eigen::Vector2f(5.0F, -4.0F);
  tracks_[8].observations[1].normalised = undistort(kCamera, places.px[1].cast<double>());
  align();
  ASSERT_EQ(tracks_[8].observations.size(), kFrames - 1);
  EXPECT_EQ(tracks_[8].observations[1].frame, 2);
}

TEST_F(AlignTracks, WithoutAnImageObservationsStayAsTheyWereDetected) {
  const InitialTrack before = tracks_[8];
  images_->crop_of.fill(-1);
  align();
  ASSERT_EQ(tracks_[8].observations.size(), kFrames);
  for (std::size_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(tracks_[8].observations[i].normalised, before.observations[i].normalised);
  }
}

TEST_F(AlignTracks, WhereNothingWasDetectedRowsTimesAreThoseOfTheMiddleView) {
  add_track({32.0, 29.0}, 0b0010110U);
  const Eigen::Vector2d shift(0.01, -0.02);
  for (InitialObservation& o : tracks_.back().observations) {
    o.normalised += shift;
  }
  align();
  ASSERT_EQ(tracks_.back().observations.size(), kFrames);
  const InitialObservation& first = tracks_.back().observations[0];
  const Eigen::Vector2d seen_px = project_px(kCamera, Eigen::Vector2d(first.normalised - shift));
  EXPECT_LT((seen_px - views_[0].place({32.0, 29.0})).norm(), 3.0 * kDetection_px);
}

}  // namespace
}  // namespace polhode::align_test
