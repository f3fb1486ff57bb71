// A mask that distinguishes nothing any more.
#include <gtest/gtest.h>

#include <memory>

#include "mask/follow.hpp"
#include "moving_scene.hpp"

namespace polhode::is_open_test {
namespace {

using moving::Scene;

constexpr int kFrames = 16;

struct Mask {
  std::unique_ptr<MaskState> state = std::make_unique<MaskState>();
  TargetMask target;
  MaskOptions options;

  void show(const cv::Mat& image) {
    find_target(image, options, &target);
    follow_target(image, {}, options, state.get(), &target);
  }
  void show(const Scene& scene, int first, int frames) {
    for (int i = first; i < first + frames; ++i) {
      show(scene.image(i));
    }
  }
};

TEST(IsOpen, OnceNoMotionHasExplainedWhatIsBehindForSomeImages) {
  Mask mask;
  EXPECT_FALSE(is_open(*mask.state)) << "no image yet";
  const auto show_unlike = [&](std::uint64_t seed) {
    Scene scene{.target = false};
    scene.behind = moving::texture(900, seed);
    mask.show(scene.image(0));
  };
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  mask.show(scene, 0, kFrames);
  ASSERT_TRUE(mask.state->found);
  EXPECT_FALSE(is_open(*mask.state));
  int images = 0;
  for (; images < 20 && !is_open(*mask.state); ++images) {
    show_unlike(10 + static_cast<std::uint64_t>(images));
  }
  EXPECT_GE(images, 5) << "a few badly tracked images do not open it";
  ASSERT_LT(images, 20);
  EXPECT_GT(mask.target.coverage, 0.9) << "everything lit";
  mask.show(scene, kFrames, kFrames);
  EXPECT_FALSE(is_open(*mask.state)) << "a motion explains it again";
}

TEST(IsOpen, NotWhereAMotionExplainsAll_ThoughThereIsNoTarget) {
  Mask mask;
  mask.show(Scene{.background_px = {3.0, 1.0}, .target = false}, 0, kFrames);
  EXPECT_TRUE(mask.state->behind);
  EXPECT_FALSE(mask.state->found);
  EXPECT_FALSE(is_open(*mask.state));
}

TEST(IsOpen, NotBeforeBlackSpace) {
  Mask mask;
  mask.show(Scene{.target_turn_deg = 3.0, .background = false}, 0, kFrames);
  EXPECT_FALSE(mask.state->behind);
  EXPECT_FALSE(is_open(*mask.state));
}

TEST(MayBeBackground, WhereTheOutlineCoversMuchOfTheBorder) {
  Mask mask;
  mask.show(Scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0}, 0, kFrames);
  ASSERT_TRUE(mask.state->found);
  EXPECT_FALSE(may_be_background(*mask.state));
  cv::Mat& outline = mask.state->outline;
  outline.row(0).colRange(0, outline.cols / 4).setTo(255);
  EXPECT_FALSE(may_be_background(*mask.state)) << "a body that enters the picture";
  outline.row(0).setTo(255);
  EXPECT_TRUE(may_be_background(*mask.state));
  mask.state->behind = false;
  EXPECT_FALSE(may_be_background(*mask.state)) << "before black space it is the target";
}

TEST(MayBeBackground, WhereNoMotionOfWhatIsBehindWasFound_AndTheOutlineIsTheLastOnes) {
  Mask mask;
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  mask.show(scene, 0, kFrames);
  ASSERT_TRUE(mask.state->found);
  ASSERT_EQ(mask.state->unexplained, 0);
  EXPECT_FALSE(may_be_background(*mask.state));
  mask.state->unexplained = 1;
  EXPECT_TRUE(may_be_background(*mask.state));
  mask.show(scene, kFrames, 2);
  EXPECT_FALSE(may_be_background(*mask.state)) << "a motion explains it again";
}

TEST(MayBeBackground, WhereAnOpenMaskIsFollowedAtTheBorder) {
  Mask mask;
  for (std::uint64_t seed = 10; seed < 30 && !is_open(*mask.state); ++seed) {
    Scene scene{.target = false};
    scene.behind = moving::texture(900, seed);
    mask.show(scene.image(0));
  }
  ASSERT_TRUE(is_open(*mask.state));
  const cv::Rect whole = mask.state->points.whole();
  auto& tracks = mask.state->points.tracks;
  const auto follow = [&](std::size_t count, float u_share, std::size_t images) {
    tracks.clear();
    for (std::size_t i = 0; i < count; ++i) {
      MaskTrack track;
      track.places[0] = {u_share * static_cast<float>(whole.width),
                         0.5F * static_cast<float>(whole.height)};
      track.count = images;
      ASSERT_TRUE(tracks.push_back(track));
    }
  };
  constexpr std::size_t kEnough = BackgroundMotion::kLayerTracksMin;
  follow(kEnough, 0.05F, 2);
  EXPECT_TRUE(may_be_background(*mask.state));
  follow(kEnough - 1, 0.05F, 2);
  EXPECT_FALSE(may_be_background(*mask.state)) << "a boom that crosses the border";
  follow(kEnough, 0.05F, 1);
  EXPECT_FALSE(may_be_background(*mask.state)) << "seen once: not followed";
  follow(kEnough, 0.5F, 2);
  EXPECT_FALSE(may_be_background(*mask.state)) << "in the middle";
}

}  // namespace
}  // namespace polhode::is_open_test
