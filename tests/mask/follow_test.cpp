#include "mask/follow.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "moving_scene.hpp"

namespace polhode::follow_test {
namespace {

using moving::overlap;
using moving::Scene;

/// A mask that has followed a scene.
struct Follower {
  std::unique_ptr<MaskState> state = std::make_unique<MaskState>();
  TargetMask mask;
  MaskOptions options;

  void show(const cv::Mat& image, const MaskPrior& prior = {}) {
    find_target(image, options, &mask);
    follow_target(image, prior, options, state.get(), &mask);
  }
  void show(const Scene& scene, int first, int frames, const MaskPrior& prior = {}) {
    for (int i = first; i < first + frames; ++i) {
      show(scene.image(i), prior);
    }
  }
};

constexpr int kFrames = 16;

/// Landmarks all over a disc.
std::vector<cv::Point2f> landmarks_of_disc(const cv::Point2d& centre, double radius_px) {
  std::vector<cv::Point2f> points;
  for (int i = 0; i < 60; ++i) {
    const double angle = 2.4 * i;
    const double r = radius_px * std::sqrt((i + 0.5) / 60.0);
    points.emplace_back(centre + cv::Point2d(r * std::cos(angle), r * std::sin(angle)));
  }
  return points;
}

/// Part of the target in which features may be made.
double open_part(const TargetMask& mask, const cv::Mat& truth) {
  int open = 0;
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      open += truth.at<std::uint8_t>(v, u) != 0 && mask.contains(u, v) ? 1 : 0;
    }
  }
  return static_cast<double>(open) / cv::countNonZero(truth);
}

/// The target is found and nothing else: half of it before the graph cut, most of it after.
void expect_found(const Scene& scene, double overlap_min, double open_min = 0.3) {
  Follower follower;
  follower.show(scene, 0, kFrames);
  EXPECT_TRUE(follower.state->behind);
  ASSERT_TRUE(follower.state->found);
  const cv::Mat truth = scene.truth(kFrames - 1);
  sharpen_outline(follower.state.get());
  EXPECT_GE(overlap(follower.state->outline, truth), overlap_min);
  EXPECT_GE(open_part(follower.mask, truth), open_min);
  EXPECT_FALSE(follower.mask.contains(10.0, 230.0));
  EXPECT_FALSE(follower.mask.contains(310.0, 230.0));
  EXPECT_LT(follower.mask.coverage, 0.25);
}

// verifies: MSK-02
TEST(FollowTarget, FindsARotatingTarget_BeforeAMovingBackground) {
  expect_found({.background_px = {3.0, 1.0}, .target_turn_deg = 3.0}, 0.75);
}

// verifies: MSK-02
TEST(FollowTarget, FindsARotatingTarget_BeforeAStaticRoom) {
  expect_found({.target_turn_deg = 3.0}, 0.75);
}

TEST(FollowTarget, FindsATargetThatDoesNotRotate_BeforeAMovingBackground) {
  expect_found({.background_px = {3.0, -1.0}}, 0.75);
}

TEST(FollowTarget, FindsASlowTarget_BeforeAStaticRoom) {
  // Near its axis it moves by less than the noise shows; edges have to do the rest.
  expect_found({.target_px = {0.3, 0.1}, .target_turn_deg = 0.4}, 0.4, 0.05);
}

TEST(FollowTarget, FindsATargetThatCrossesTheLimb) {
  const Scene scene{.background_px = {2.0, 1.0},
                    .target_px = {0.0, -4.0},
                    .target_turn_deg = 3.0,
                    .start_px = {160.0, 180.0},
                    .horizon_row = 120};
  expect_found(scene, 0.5);  // it moves by half its size while its log-odds last
}

// verifies: MSK-03
TEST(FollowTarget, FindsNothing_WhereOnlyTheBackgroundIs) {
  for (const cv::Point2d& motion : {cv::Point2d(0.0, 0.0), cv::Point2d(3.0, 1.0)}) {
    Follower follower;
    follower.show({.background_px = motion, .target = false}, 0, kFrames);
    EXPECT_FALSE(follower.state->found);
    EXPECT_TRUE(follower.mask.region_px.empty());
    EXPECT_EQ(follower.mask.coverage, 0.0);
  }
}

TEST(FollowTarget, IsFindTarget_BeforeBlackSpace) {
  const Scene scene{.target_px = {1.0, 0.5}, .target_turn_deg = 4.0, .background = false};
  Follower follower;
  for (int i = 0; i < 6; ++i) {
    follower.show(scene, i, 1);
    TargetMask alone;
    find_target(scene.image(i), {}, &alone);
    EXPECT_FALSE(follower.state->behind);
    EXPECT_EQ(follower.mask.region_px, alone.region_px);
    EXPECT_EQ(cv::norm(follower.mask.cells, alone.cells, cv::NORM_L1), 0.0);
  }
}

TEST(FollowTarget, IsFindTarget_WhenTheBackgroundIsNotToBeSeparated) {
  Follower follower;
  follower.options.background = false;
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  follower.show(scene, 0, 4);
  EXPECT_EQ(follower.mask.region_px, cv::Rect(0, 0, moving::kWidth, moving::kHeight));
}

TEST(FollowTarget, TakesEverythingLit_WhereNoMotionExplainsTheBackground) {
  Follower follower;
  for (int i = 0; i < 8; ++i) {
    Scene scene{.target = false};
    scene.behind =
        moving::texture(900, static_cast<std::uint64_t>(100 + i));  // another one each time
    follower.show(scene, i, 1);
  }
  EXPECT_FALSE(follower.state->found);
  EXPECT_EQ(follower.mask.region_px, cv::Rect(0, 0, moving::kWidth, moving::kHeight));
}

TEST(FollowTarget, KeepsTheTarget_WhereTheMapPredictsIt_ThoughNothingMoves) {
  const Scene scene;
  const std::vector<cv::Point2f> points = landmarks_of_disc({160.0, 120.0}, 38.0);
  Follower follower;
  follower.show(scene, 0, kFrames, {.points_px = points, .radius_px = 40.0});
  ASSERT_TRUE(follower.state->found);
  EXPECT_TRUE(follower.mask.contains(160.0, 120.0));
  EXPECT_FALSE(follower.mask.contains(160.0, 20.0));
  EXPECT_GE(overlap(follower.state->outline, scene.truth(0)), 0.7);
}

TEST(FollowTarget, KeepsTheTarget_WhileAPoseIsLostAndFoundAgain) {
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  const std::vector<cv::Point2f> points = landmarks_of_disc({160.0, 120.0}, 34.0);
  const MaskPrior map{.points_px = points, .radius_px = 40.0};
  Follower follower;
  follower.show(scene, 0, kFrames);
  int frame = kFrames;
  for (const MaskPrior& prior : {map, MaskPrior{}, map}) {
    for (int i = 0; i < 3; ++i, ++frame) {
      follower.show(scene, frame, 1, prior);
      ASSERT_TRUE(follower.state->found) << frame;
      EXPECT_EQ(follower.state->foreground.step, prior.points_px.empty() ? 1 : 2) << frame;
      sharpen_outline(follower.state.get());
      EXPECT_GE(overlap(follower.state->outline, scene.truth(frame)), 0.8) << frame;
    }
  }
}

TEST(FollowTarget, FindsTheTargetAgain_AfterTheBackgroundWasAwayForAWhile) {
  Follower follower;
  const Scene with{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  Scene without = with;
  without.background = false;
  follower.show(with, 0, 8);
  follower.show(without, 8, 4);
  EXPECT_FALSE(follower.state->behind);
  follower.show(with, 12, kFrames);
  EXPECT_TRUE(follower.state->found);
  EXPECT_GE(open_part(follower.mask, with.truth(0)), 0.3);
}

TEST(FollowTarget, SaysTheSame_WhenShownTheSame_WhateverWasThereBefore) {
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  Follower a;
  Follower b;
  Follower after_black;
  Scene black = scene;
  black.background = false;
  after_black.show(black, 0, 3);
  const Scene other{
      .background_px = {-2.0, 0.0}, .target_turn_deg = -5.0, .start_px = {100.0, 90.0}};
  const std::vector<cv::Point2f> points = landmarks_of_disc({100.0, 90.0}, 34.0);
  b.show(other, 0, 9, {.points_px = points, .radius_px = 40.0});
  sharpen_outline(b.state.get());
  clear(b.state.get());
  a.show(scene, 0, kFrames);
  ASSERT_TRUE(a.state->found);
  for (Follower* other_one : {&b, &after_black}) {
    other_one->show(scene, 0, kFrames);
    EXPECT_EQ(cv::norm(a.mask.cells, other_one->mask.cells, cv::NORM_L1), 0.0);
    EXPECT_EQ(
        cv::norm(a.state->foreground.log_odds, other_one->state->foreground.log_odds, cv::NORM_L1),
        0.0);
  }
}

TEST(FollowTarget, RemembersARoom_WhileTheCameraStandsStill) {
  Follower follower;
  const Scene still{.target_px = {2.0, 0.0}, .target_turn_deg = 3.0};
  follower.show(still, 0, 30);
  const auto known = [&] { return cv::countNonZero(follower.state->background_model.votes >= 4); };
  EXPECT_GT(known(), moving::kWidth * moving::kHeight / 2);
  match_background(still.image(29), still.noise, &follower.state->background_model);
  const cv::Mat& matches = follower.state->background_model.matches;
  // Levels from 60 to 200 on both sides: a tenth of the target is within the noise of what is
  // behind it.
  EXPECT_LT(cv::countNonZero(matches & still.truth(29)), cv::countNonZero(still.truth(29)) / 5);
  EXPECT_GT(cv::countNonZero(matches & ~still.truth(29)), known() * 9 / 10);
  Scene moving = still;
  moving.background_px = {3.0, 1.0};
  follower.show(moving, 30, 6);
  EXPECT_EQ(known(), 0);
}

TEST(RulesOut, WhatLiesBeyondASharpenedOutline_AndNothingWithoutOne) {
  Follower follower;
  EXPECT_FALSE(rules_out(*follower.state, 10.0F, 10.0F));
  const Scene scene{.target_turn_deg = 3.0};
  follower.show(scene, 0, kFrames);
  EXPECT_FALSE(rules_out(*follower.state, 10.0F, 10.0F));
  sharpen_outline(follower.state.get());
  ASSERT_TRUE(follower.state->sharp);
  const cv::Point2d c = scene.centre(kFrames - 1);
  const auto ruled_out = [&](double from_centre_px) {
    return rules_out(
        *follower.state, static_cast<float>(c.x + from_centre_px), static_cast<float>(c.y));
  };
  EXPECT_FALSE(ruled_out(0.0));
  EXPECT_FALSE(ruled_out(scene.radius_px + 1.0));
  EXPECT_TRUE(ruled_out(scene.radius_px + 15.0));
  EXPECT_TRUE(rules_out(*follower.state, -3.0F, 500.0F));  // not in the image
  follower.show(scene, kFrames, 1);
  EXPECT_FALSE(ruled_out(scene.radius_px + 15.0));
}

TEST(OpenOutline, LeavesTheMaskToTheMap_WhereThereIsOne) {
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  const std::vector<cv::Point2f> points = landmarks_of_disc({161.0, 119.0}, 34.0);
  Follower follower;
  follower.show(scene, 0, kFrames, {.points_px = points, .radius_px = 40.0});
  sharpen_outline(follower.state.get());
  ASSERT_TRUE(follower.state->sharp);
  const cv::Mat before = follower.mask.cells.clone();
  open_outline(scene.image(0).size(), follower.state.get(), &follower.mask);
  EXPECT_EQ(cv::norm(before, follower.mask.cells, cv::NORM_INF), 0.0);
}

TEST(OpenOutline, OpensTheBodyToItsSilhouette_BeforeAMap) {
  const Scene scene{.target_turn_deg = 3.0};
  const cv::Size size = scene.image(0).size();
  Follower follower;
  follower.show(scene, 0, kFrames);
  const cv::Mat truth = scene.truth(kFrames - 1);
  const double by_motion = open_part(follower.mask, truth);
  open_outline(size, follower.state.get(), &follower.mask);
  EXPECT_EQ(open_part(follower.mask, truth), by_motion) << "nothing is sharpened yet";
  sharpen_outline(follower.state.get());
  open_outline(size, follower.state.get(), &follower.mask);
  EXPECT_LT(by_motion, 0.97);
  EXPECT_GE(open_part(follower.mask, truth), 0.99);
  EXPECT_LT(follower.mask.coverage, 0.25);
  EXPECT_EQ(follower.mask.region_px & cv::Rect(cv::Point(), size), follower.mask.region_px);
  const cv::Point2d c = scene.centre(kFrames - 1);
  EXPECT_FALSE(follower.mask.contains(c.x + scene.radius_px + 20.0, c.y));
}

TEST(FollowTarget, ClassifiesTracks) {
  Follower follower;
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  follower.show(scene, 0, kFrames);
  struct {
    int beside = 0, on_target = 0;
  } background, target;
  for (const MaskTrack& track : follower.state->points.tracks) {
    const double from_centre = cv::norm(cv::Point2d(track.now()) - scene.centre(kFrames - 1));
    if (track.kind != TrackClass::kUnassigned) {
      auto& of = track.kind == TrackClass::kTarget ? target : background;
      (from_centre > scene.radius_px ? of.beside : of.on_target) += 1;
    }
  }
  EXPECT_GE(background.beside, 50);
  EXPECT_LE(background.on_target, background.beside / 20);
  EXPECT_GE(target.on_target, 20);
  EXPECT_LE(target.beside, target.on_target / 10);
}

TEST(SharpenOutline, FindsTheEdge_FromAPriorThatIsOffByAFewPixels) {
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  const std::vector<cv::Point2f> points = landmarks_of_disc({161.0, 119.0}, 34.0);
  Follower follower;
  follower.show(scene, 0, kFrames, {.points_px = points, .radius_px = 40.0});
  sharpen_outline(follower.state.get());
  EXPECT_TRUE(follower.state->sharp);
  // Both sides of the edge are of the same texture: motion alone distinguishes them, to 3 px of 40.
  EXPECT_GE(overlap(follower.state->outline, scene.truth(kFrames - 1)), 0.8);
}

TEST(SharpenOutline, LeavesAnOutlineAsItWas_WhereNothingOfItWouldBeLeft) {
  // Textures on both sides whose steps are all alike: a cut along the silhouette of a small body
  // costs more than to give it up.
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 8.0, .radius_px = 8.0};
  Follower follower;
  follower.show(scene, 0, kFrames);
  ASSERT_TRUE(follower.state->found);
  const cv::Mat before = follower.state->outline.clone();
  sharpen_outline(follower.state.get());
  EXPECT_FALSE(follower.state->sharp);
  EXPECT_GE(overlap(follower.state->outline, before), 0.5);
  EXPECT_FALSE(rules_out(*follower.state, 10.0F, 10.0F));
  follower.show(scene, kFrames, 1);
  EXPECT_TRUE(follower.state->found);
}

TEST(FollowTarget, FindsATarget_BesideAStripOfBackground) {
  Follower follower;
  const Scene scene{.background_px = {2.0, 1.0}, .target_turn_deg = 3.0, .horizon_row = 195};
  follower.show(scene, 0, kFrames);
  EXPECT_TRUE(follower.state->behind) << "a fifth of the picture, three tenths of its border";
  EXPECT_FALSE(follower.mask.contains(10.0, 230.0));
  EXPECT_FALSE(follower.mask.contains(310.0, 230.0));
  EXPECT_GE(open_part(follower.mask, scene.truth(kFrames - 1)), 0.3);
}

TEST(FollowTarget, AKnownBodyThatFillsTheImageBorderIsNoBackground) {
  const Scene scene{.radius_px = 250.0, .background = false};
  const cv::Mat image = scene.image(0);
  Follower follower;
  follower.show(image);
  EXPECT_TRUE(follower.state->behind) << "nobody knows yet";
  std::vector<cv::Point2f> landmarks;
  for (float u_px = 20.0F; u_px < 310.0F; u_px += 20.0F) {
    for (float v_px = 10.0F; v_px < 240.0F; v_px += 20.0F) {
      landmarks.emplace_back(u_px, v_px);
    }
  }
  Follower knowing;
  knowing.show(image, {.points_px = landmarks, .radius_px = 250.0});
  EXPECT_FALSE(knowing.state->behind);
  EXPECT_GT(open_part(knowing.mask, scene.truth(0)), 0.9);
}

TEST(FollowTarget, WhatATargetStandsOnIsNoBackground) {
  const Scene scene{.background = false};
  cv::Mat image = scene.image(0);
  image(cv::Rect(0, 200, moving::kWidth, 40)).setTo(90);
  cv::Mat standing = image.clone();
  standing(cv::Rect(150, 150, 20, 60)).setTo(90);
  Follower apart;
  apart.show(image);
  EXPECT_TRUE(apart.state->behind);
  Follower one_piece;
  one_piece.show(standing);
  EXPECT_FALSE(one_piece.state->behind);
}

TEST(FollowTarget, KeepsItsLandmarksOpen_WhenSomethingComesBehindThem) {
  const Scene scene{.background_px = {2.0, 1.0}};
  std::vector<cv::Point2f> landmarks;
  for (float turn = 0.0F; turn < 6.2F; turn += 0.2F) {
    for (const float radius_px : {10.0F, 20.0F, 30.0F}) {
      landmarks.emplace_back(160.0F + radius_px * std::cos(turn),
                             120.0F + radius_px * std::sin(turn));
    }
  }
  Follower follower;
  follower.show(scene, 0, 1, {.points_px = landmarks, .radius_px = scene.radius_px});
  ASSERT_TRUE(follower.state->behind);
  EXPECT_GT(open_part(follower.mask, scene.truth(0)), 0.4) << "in its first picture";
}

TEST(FollowTarget, IgnoresLandmarksThatTheImagesContradictEverywhere) {
  const Scene scene{.background_px = {3.0, 1.0}, .target_turn_deg = 3.0};
  Follower follower;
  follower.show(scene, 0, kFrames);
  ASSERT_TRUE(follower.state->found);
  const std::vector<cv::Point2f> astray(40, {30.0F, 30.0F});
  follower.show(scene, kFrames, 2, {.points_px = astray, .radius_px = scene.radius_px});
  EXPECT_GE(open_part(follower.mask, scene.truth(kFrames + 1)), 0.3);
}

}  // namespace
}  // namespace polhode::follow_test
