#include "map/landmarks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "synthetic_map.hpp"

namespace polhode::landmarks_test {
namespace {

using namespace synthetic;

/// Distance of each used landmark from the nearest spot of the body.
std::vector<double> errors_of(const Map& map,
                              const std::vector<Spot>& body,
                              std::int32_t first_number) {
  std::vector<double> errors;
  for (const Landmark& landmark : map.landmarks) {
    if (!landmark.used || landmark.number < first_number) {
      continue;
    }
    double nearest = 1e9;
    for (const Spot& spot : body) {
      nearest = std::min(nearest, (spot.p_T - landmark.p_T).norm());
    }
    errors.push_back(nearest);
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

struct Bench {
  static constexpr std::size_t kMapped = 250;
  std::vector<Spot> body = ball(500, 41);
  SyntheticMap s = make_map(body, turn_by(0.15, 4), kNoise_px, 41, kMapped);
  std::unique_ptr<CreateScratch> scratch = std::make_unique<CreateScratch>();
  std::int32_t first = s.map->next_landmark_number;

  int create() {
    return create_landmarks(s.keyframes.back(), {}, camera(), scratch.get(), s.map.get());
  }
};

TEST(CreateLandmarks, FindsTheSpotsThatWereNotMapped) {
  Bench b;
  const int count_before = b.s.map->landmark_count;
  const int made = b.create();
  EXPECT_GT(made, 50) << "some 90 unmapped spots face the newest keyframe";
  EXPECT_EQ(b.s.map->landmark_count, count_before + made);
  EXPECT_EQ(broken_promise(*b.s.map), "");
  const auto errors = errors_of(*b.s.map, b.body, b.first);
  ASSERT_EQ(static_cast<int>(errors.size()), made);
  // 0.5 px at 8 / 1500 per pixel is 2.7 mm across the line of sight; along it sqrt(2) / parallax
  // (0.15 rad) of that, 25 mm for neighbouring keyframes.
  EXPECT_LT(errors[errors.size() / 2], 0.03);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.1);
}

TEST(CreateLandmarks, MakesEachSpotOnce) {
  Bench b;
  EXPECT_GT(b.create(), 50);
  EXPECT_LE(b.create(), 5) << "what is mapped is not free any more";
  EXPECT_EQ(broken_promise(*b.s.map), "");
}

TEST(CreateLandmarks, MakesNone_WithoutParallax) {
  const auto body = ball(300, 42);
  std::vector<Pose> poses{turned(0.0), turned(0.005), turned(0.01)};
  auto s = make_map(body, poses, kNoise_px, 42, 150);
  const auto scratch = std::make_unique<CreateScratch>();
  EXPECT_EQ(
      create_landmarks(
          s.keyframes.back(), {.parallax_min_rad = 0.035}, camera(), scratch.get(), s.map.get()),
      0);
}

TEST(CreateLandmarks, MakesFew_WhenTheImagesShowDifferentBodies) {
  Bench b;
  Rng rng(43, 131);
  const Picture other = take_image(ball(500, 43), turned(0.6), kNoise_px, 0, &rng);
  const KeyframeId id = add_keyframe(b.s.map.get());
  b.s.map->keyframes[id.index()].pose = turned(0.6);
  b.s.map->keyframes[id.index()].features = *other.features;
  // An unrelated feature near the epipolar line passes where it happens to have no rival: a few in
  // a hundred.
  EXPECT_LE(create_landmarks(id, {}, camera(), b.scratch.get(), b.s.map.get()),
            static_cast<int>(other.features->size() / 10));
  EXPECT_EQ(broken_promise(*b.s.map), "");
}

TEST(CreateLandmarks, EndsWell_WhenTheTableIsFull) {
  Bench b;
  while (add_landmark(b.s.map.get()).valid()) {
  }
  EXPECT_EQ(b.create(), 0);
  EXPECT_EQ(broken_promise(*b.s.map), "");
}

TEST(ExtendLandmarks, TiesTheOtherKeyframesThatSeeANewLandmark) {
  Bench b;
  ASSERT_GT(b.create(), 50);
  refresh_landmarks(b.s.map.get(), camera());
  EXPECT_GT(extend_landmarks(b.first, camera(), b.s.map.get()), 30);
  EXPECT_EQ(broken_promise(*b.s.map), "");
  int confirmed = 0;
  for (const Landmark& landmark : b.s.map->landmarks) {
    confirmed += landmark.used && landmark.number >= b.first && landmark.observations >= 3 ? 1 : 0;
  }
  EXPECT_GT(confirmed, 30);
  EXPECT_EQ(extend_landmarks(b.s.map->next_landmark_number, camera(), b.s.map.get()), 0)
      << "none is that young";
}

TEST(CullLandmarks, LeavesAGoodMapAlone) {
  const auto s = make_map(ball(300, 44), turn_by(0.1, 6), kNoise_px, 44);
  int old = 0;
  for (Landmark& landmark : s.map->landmarks) {
    landmark.created_keyframe = s.map->next_keyframe_number;
    old += landmark.used ? 1 : 0;
  }
  // Truth and noise of one sigma: 16 squared sigmas are exceeded once in 3000 times.
  EXPECT_LE(cull_landmarks(camera(), 1.0, s.map.get()), 3);
  EXPECT_GE(s.map->landmark_count, old - 3);
  EXPECT_EQ(broken_promise(*s.map), "");
}

TEST(CullLandmarks, UntiesWrongObservations_AndRemovesLandmarksThatOneKeyframeSees) {
  const auto s = make_map(ball(300, 45), turn_by(0.1, 6), 0.2, 45);
  // A landmark out of its place fits in no keyframe.
  std::vector<LandmarkId> wrong;
  for (std::size_t spot = 0; spot < s.landmark_of.size() && wrong.size() < 10; ++spot) {
    if (s.landmark_of[spot].valid()) {
      wrong.push_back(s.landmark_of[spot]);
      s.map->landmarks[wrong.back().index()].p_T *= 0.8;
    }
  }
  // One wrong observation of a good landmark.
  const KeyframeId k = s.keyframes[2];
  std::size_t feature = 0;
  for (std::size_t i = 0; i < s.map->keyframes[k.index()].features.size(); ++i) {
    const LandmarkId id = s.map->keyframes[k.index()].landmark_of[i];
    if (id.valid() && s.map->landmarks[id.index()].observations >= 5 &&
        std::find(wrong.begin(), wrong.end(), id) == wrong.end()) {
      feature = i;
    }
  }
  const LandmarkId victim = s.map->keyframes[k.index()].landmark_of[feature];
  ASSERT_TRUE(victim.valid());
  const int observations = s.map->landmarks[victim.index()].observations;
  s.map->keyframes[k.index()].features[feature].normalised += Eigen::Vector2d(0.01, 0.01);
  EXPECT_GE(cull_landmarks(camera(), 1.0, s.map.get()), 10);
  for (const LandmarkId id : wrong) {
    EXPECT_FALSE(s.map->landmarks[id.index()].used);
  }
  EXPECT_TRUE(s.map->landmarks[victim.index()].used);
  EXPECT_EQ(s.map->landmarks[victim.index()].observations, observations - 1);
  EXPECT_FALSE(s.map->keyframes[k.index()].landmark_of[feature].valid());
  EXPECT_EQ(broken_promise(*s.map), "");
}

TEST(CullLandmarks, ForgivesMore_WhenTheNoiseIsLarger) {
  const auto strict = make_map(ball(300, 46), turn_by(0.1, 6), 3.0 * kNoise_px, 46);
  const auto mild = make_map(ball(300, 46), turn_by(0.1, 6), 3.0 * kNoise_px, 46);
  cull_landmarks(camera(), 1.0, strict.map.get());
  cull_landmarks(camera(), 3.0, mild.map.get());
  EXPECT_GT(mild.map->landmark_count, strict.map->landmark_count);
}

TEST(ResidualScale, TellsByHowMuchTheNoiseExceedsItsSigma) {
  for (const double factor : {0.5, 1.0, 2.5}) {
    const auto s = make_map(ball(400, 47), turn_by(0.1, 8), factor * kNoise_px, 47);
    // The median of 1000 squares has a relative deviation of about 5 %, half of it for the scale;
    // four of them.
    EXPECT_NEAR(residual_scale(*s.map, camera()), factor, 0.1 * factor);
  }
}

TEST(ResidualScale, IsNotMovedMuch_ByWrongObservations) {
  const auto s = make_map(ball(400, 48), turn_by(0.1, 8), kNoise_px, 48);
  for (const KeyframeId id : s.keyframes) {
    Features& features = s.map->keyframes[id.index()].features;
    for (std::size_t i = 0; i < features.size(); i += 10) {
      features[i].normalised += Eigen::Vector2d(0.05, 0.0);
    }
  }
  // A tenth of wild values moves the median to the 5/9 quantile: ln(9/4) / ln 2 = 1.17 in
  // squares, 1.08 in scale.
  EXPECT_NEAR(residual_scale(*s.map, camera()), 1.08, 0.1);
}

TEST(ResidualScale, IsOne_WhenThereIsTooLittleToTell) {
  const auto map = std::make_unique<Map>();
  EXPECT_EQ(residual_scale(*map, camera()), 1.0);
}

}  // namespace
}  // namespace polhode::landmarks_test
