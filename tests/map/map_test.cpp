#include "map/map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "synthetic_map.hpp"

namespace polhode::map_test {
namespace {

using synthetic::broken_promise;

KeyframeId keyframe_with_features(std::size_t features, Map* map) {
  const KeyframeId id = add_keyframe(map);
  if (id.valid()) {
    map->keyframes[id.index()].features.resize(features);
  }
  return id;
}

TEST(Map, IsEmptyAtFirst) {
  const auto map = std::make_unique<Map>();
  EXPECT_TRUE(keyframes_by_age(*map).empty());
  EXPECT_EQ(broken_promise(*map), "");
}

TEST(Map, AnswersWithAnInvalidId_WhenATableIsFull) {
  const auto map = std::make_unique<Map>();
  std::set<std::int32_t> slots;
  for (std::size_t i = 0; i < limits::kKeyframes; ++i) {
    slots.insert(add_keyframe(map.get()).slot);
  }
  EXPECT_EQ(slots.size(), limits::kKeyframes);
  EXPECT_FALSE(add_keyframe(map.get()).valid());
  for (std::size_t i = 0; i < limits::kLandmarks; ++i) {
    ASSERT_TRUE(add_landmark(map.get()).valid());
  }
  EXPECT_FALSE(add_landmark(map.get()).valid());
  EXPECT_EQ(broken_promise(*map), "");
  remove_keyframe(KeyframeId::from_index(17), map.get());
  remove_landmark(LandmarkId::from_index(23), map.get());
  EXPECT_EQ(add_keyframe(map.get()), KeyframeId::from_index(17));
  EXPECT_EQ(add_landmark(map.get()), LandmarkId::from_index(23));
  EXPECT_EQ(broken_promise(*map), "");
}

TEST(Map, NeverUsesANumberTwice_EvenAfterClear) {
  const auto map = std::make_unique<Map>();
  std::set<std::uint32_t> keyframes;
  std::set<std::int32_t> landmarks;
  for (int i = 0; i < 50; ++i) {
    const KeyframeId k = add_keyframe(map.get());
    const LandmarkId l = add_landmark(map.get());
    EXPECT_TRUE(keyframes.insert(map->keyframes[k.index()].number).second);
    EXPECT_TRUE(landmarks.insert(map->landmarks[l.index()].number).second);
    if (i % 3 == 0) {
      remove_keyframe(k, map.get());
      remove_landmark(l, map.get());
    }
    if (i == 30) {
      clear(map.get());
      EXPECT_EQ(broken_promise(*map), "");
    }
  }
}

TEST(Map, GivesAReusedSlotWithoutItsPast) {
  const auto map = std::make_unique<Map>();
  const KeyframeId a = keyframe_with_features(5, map.get());
  const KeyframeId b = keyframe_with_features(5, map.get());
  const LandmarkId l = add_landmark(map.get());
  add_observation(a, 2, l, map.get());
  add_observation(b, 3, l, map.get());
  map->landmarks[l.index()].found = 7;
  remove_landmark(l, map.get());
  EXPECT_FALSE(map->keyframes[a.index()].landmark_of[2].valid());
  const LandmarkId again = add_landmark(map.get());
  ASSERT_EQ(again, l);
  EXPECT_EQ(map->landmarks[l.index()].observations, 0);
  EXPECT_EQ(map->landmarks[l.index()].found, 0);
  remove_keyframe(a, map.get());
  const KeyframeId fresh = add_keyframe(map.get());
  ASSERT_EQ(fresh, a);
  EXPECT_TRUE(map->keyframes[a.index()].features.empty());
  EXPECT_EQ(broken_promise(*map), "");
}

TEST(Map, LosesLandmarksThatOneKeyframeSees_WhenAnotherGoes) {
  const auto map = std::make_unique<Map>();
  const KeyframeId a = keyframe_with_features(5, map.get());
  const KeyframeId b = keyframe_with_features(5, map.get());
  const KeyframeId c = keyframe_with_features(5, map.get());
  const LandmarkId by_two = add_landmark(map.get());
  const LandmarkId by_three = add_landmark(map.get());
  const LandmarkId elsewhere = add_landmark(map.get());
  for (const KeyframeId k : {a, b}) {
    add_observation(k, 0, by_two, map.get());
    add_observation(k, 1, by_three, map.get());
  }
  add_observation(c, 1, by_three, map.get());
  add_observation(b, 2, elsewhere, map.get());
  add_observation(c, 2, elsewhere, map.get());
  remove_keyframe(a, map.get());
  EXPECT_FALSE(map->landmarks[by_two.index()].used);
  EXPECT_TRUE(map->landmarks[by_three.index()].used);
  EXPECT_EQ(map->landmarks[by_three.index()].observations, 2);
  EXPECT_EQ(map->landmarks[elsewhere.index()].observations, 2);
  EXPECT_FALSE(map->keyframes[b.index()].landmark_of[0].valid());
  EXPECT_EQ(broken_promise(*map), "");
}

TEST(Map, WithdrawsTheKeyframeOfATime) {
  const auto map = std::make_unique<Map>();
  for (const std::int64_t timestamp_ns : {10, 20, 30}) {
    map->keyframes[keyframe_with_features(5, map.get()).index()].timestamp_ns = timestamp_ns;
  }
  withdraw_keyframe(15, map.get());
  EXPECT_EQ(map->keyframe_count, 3);
  withdraw_keyframe(20, map.get());
  EXPECT_EQ(map->keyframe_count, 2);
  EXPECT_TRUE(std::none_of(map->keyframes.begin(), map->keyframes.end(), [](const Keyframe& k) {
    return k.used && k.timestamp_ns == 20;
  }));
  EXPECT_EQ(broken_promise(*map), "");
}

TEST(Map, RemembersTheLastKeyframeThatSawALandmark) {
  const auto map = std::make_unique<Map>();
  const KeyframeId a = keyframe_with_features(1, map.get());
  const KeyframeId b = keyframe_with_features(1, map.get());
  const LandmarkId l = add_landmark(map.get());
  add_observation(b, 0, l, map.get());
  add_observation(a, 0, l, map.get());
  EXPECT_EQ(map->landmarks[l.index()].seen_keyframe, map->keyframes[b.index()].number);
}

/// One random operation; what cannot be done is left.
void operate(Rng* rng, Map* map) {
  constexpr std::size_t kFeatures = 12;
  const auto k = KeyframeId::from_index(rng->below(8));
  const auto l = LandmarkId::from_index(rng->below(30));
  Keyframe& keyframe = map->keyframes[k.index()];
  const std::size_t feature = rng->below(kFeatures);
  switch (rng->below(10)) {
    case 0:
      if (map->keyframe_count < 8) {
        (void)keyframe_with_features(kFeatures, map);
      }
      break;
    case 1:
    case 2:
      if (map->landmark_count < 30) {
        (void)add_landmark(map);
      }
      break;
    case 3:
      if (rng->below(4) == 0 && keyframe.used) {
        remove_keyframe(k, map);
      }
      break;
    case 4:
      if (rng->below(4) == 0 && map->landmarks[l.index()].used) {
        remove_landmark(l, map);
      }
      break;
    case 5:
      if (keyframe.used && keyframe.landmark_of[feature].valid()) {
        remove_observation(k, feature, map);
      }
      break;
    default:
      if (keyframe.used && map->landmarks[l.index()].used &&
          !keyframe.landmark_of[feature].valid()) {
        add_observation(k, feature, l, map);
      }
  }
}

TEST(Map, KeepsItsPromises_UnderRandomOperations) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto map = std::make_unique<Map>();
    Rng rng(seed, 93);
    int most_landmarks = 0;
    for (int i = 0; i < 600; ++i) {
      operate(&rng, map.get());
      ASSERT_EQ(broken_promise(*map), "") << "seed " << seed << ", operation " << i;
      most_landmarks = std::max(most_landmarks, map->landmark_count);
    }
    EXPECT_GT(most_landmarks, 10) << "the property would be empty";
  }
}

TEST(KeyframesByAge, ListsTheNewestFirst_WhateverTheSlots) {
  const auto map = std::make_unique<Map>();
  for (int i = 0; i < 6; ++i) {
    (void)add_keyframe(map.get());
  }
  remove_keyframe(KeyframeId::from_index(1), map.get());
  remove_keyframe(KeyframeId::from_index(4), map.get());
  (void)add_keyframe(map.get());
  const auto order = keyframes_by_age(*map);
  ASSERT_EQ(order.size(), 5U);
  EXPECT_EQ(order[0], KeyframeId::from_index(1)) << "the newest took the first free slot";
  for (std::size_t i = 1; i < order.size(); ++i) {
    EXPECT_GT(map->keyframes[order[i - 1].index()].number, map->keyframes[order[i].index()].number);
  }
}

TEST(RefreshLandmarks, GivesTheMeanDirectionAndSizeOfEachLandmark) {
  const auto body = synthetic::ball(300, 1);
  const auto poses = synthetic::turn_by(0.15, 4);
  const auto s = synthetic::make_map(body, poses, 0.0, 1);
  ASSERT_GT(s.map->landmark_count, 50);
  for (std::size_t spot = 0; spot < body.size(); ++spot) {
    if (!s.landmark_of[spot].valid()) {
      continue;
    }
    const Landmark& landmark = s.map->landmarks[s.landmark_of[spot].index()];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const KeyframeId k : s.keyframes) {
      const Keyframe& keyframe = s.map->keyframes[k.index()];
      for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
        if (keyframe.landmark_of[i] == s.landmark_of[spot]) {
          sum += (keyframe.pose.camera_T() - landmark.p_T).normalized();
        }
      }
    }
    EXPECT_LT((landmark.normal_T - sum.normalized()).norm(), 1e-12);
    EXPECT_NEAR(landmark.size_mu, synthetic::kSpotSize_mu, 1e-6)
        << "scales are stored in single precision";
    EXPECT_GE(landmark.views.size(), 1U);
  }
}

TEST(RefreshLandmarks, GivesTheMiddleAndTheExtentOfTheBody) {
  auto body = synthetic::ball(400, 2);
  body[0].p_T *= 0.2;  // a few wild ones must not matter
  const auto s = synthetic::make_map(body, synthetic::turn_by(0.5, 13), 0.0, 2);
  ASSERT_GT(s.map->landmark_count, 300);
  // The median of 300 values spread over [-1, 1] has a deviation of about 1 / sqrt(300) = 0.06.
  EXPECT_LT(s.map->centre_T.norm(), 0.3);
  EXPECT_NEAR(s.map->radius_mu, 1.0, 0.3);
}

/// What refresh_landmarks() derives; descriptors by their first byte.
std::vector<double> derived(const Map& map) {
  std::vector<double> values{map.centre_T.x(), map.centre_T.y(), map.centre_T.z(), map.radius_mu};
  for (const Landmark& landmark : map.landmarks) {
    if (!landmark.used) {
      continue;
    }
    for (const Eigen::Vector3d& v : {landmark.normal_T, landmark.oldest_direction_T}) {
      values.insert(values.end(), {v.x(), v.y(), v.z()});
    }
    values.insert(values.end(), {landmark.size_mu, landmark.spread_rad});
    for (const LandmarkView& view : landmark.views) {
      values.insert(values.end(),
                    {view.direction_T.x(),
                     view.direction_T.y(),
                     view.direction_T.z(),
                     static_cast<double>(view.keyframe.slot),
                     static_cast<double>(view.feature),
                     static_cast<double>(view.descriptor[0])});
    }
  }
  return values;
}

/// One of the things that happen to a map, drawn.
void change(Rng* rng, synthetic::SyntheticMap* s) {
  Map& map = *s->map;
  const KeyframeId k = s->keyframes[rng->below(static_cast<std::uint32_t>(s->keyframes.size()))];
  Keyframe& keyframe = map.keyframes[k.index()];
  const std::size_t feature = rng->below(static_cast<std::uint32_t>(keyframe.features.size()));
  const LandmarkId l = keyframe.landmark_of[feature];
  switch (rng->below(6)) {
    case 0:
      keyframe.pose.p_CT.x() += 0.01;
      break;
    case 1:
      if (l.valid()) map.landmarks[l.index()].p_T.y() += 0.01;
      break;
    case 2:
      if (l.valid()) remove_observation(k, feature, &map);
      break;
    case 3:
      if (l.valid()) {
        remove_observation(k, feature, &map);
        add_observation(k, feature, l, &map);
      } else {
        add_observation(k, feature, add_landmark(&map), &map);
      }
      break;
    case 4:
      if (l.valid()) remove_landmark(l, &map);
      break;
    default:
      if (s->keyframes.size() > 5) {
        remove_keyframe(k, &map);
        std::erase(s->keyframes, k);
      }
  }
}

TEST(RefreshLandmarks, OfWhatHasChangedGivesWhatOneOfAllGives) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    auto s = synthetic::make_map(synthetic::ball(300, 2), synthetic::turn_by(0.3, 15), 0.0, seed);
    Rng rng(seed, 4);
    for (int round = 0; round < 30; ++round) {
      for (std::uint64_t i = 0; i < 1 + rng.below(5); ++i) {
        change(&rng, &s);
      }
      const auto all = std::make_unique<Map>(*s.map);
      for (Landmark& landmark : all->landmarks) {
        landmark.observations_changed = true;
      }
      refresh_landmarks(s.map.get(), synthetic::camera());
      refresh_landmarks(all.get(), synthetic::camera());
      ASSERT_EQ(derived(*s.map), derived(*all)) << "seed " << seed << ", round " << round;
    }
  }
}

TEST(RefreshLandmarks, KeepsViewsOfDifferentSides_AndTheNewestOfOneSide) {
  // One spot that looks different to each keyframe; the first two are 3 deg apart, the rest far.
  const auto map = std::make_unique<Map>();
  const LandmarkId l = add_landmark(map.get());
  const double angles_rad[] = {0.0, 0.05, 0.5, 1.0, 1.5};
  for (int k = 0; k < 5; ++k) {
    const KeyframeId id = keyframe_with_features(1, map.get());
    map->keyframes[id.index()].pose = synthetic::turned(angles_rad[k]);
    map->keyframes[id.index()].features[0].descriptor.fill(static_cast<std::uint8_t>(10 * (k + 1)));
    add_observation(id, 0, l, map.get());
    refresh_landmarks(map.get(), synthetic::camera());
    const Landmark& landmark = map->landmarks[l.index()];
    std::set<int> held;
    for (const LandmarkView& view : landmark.views) {
      held.insert(view.descriptor[0]);
      EXPECT_NEAR(view.direction_T.norm(), 1.0, 1e-12);
    }
    EXPECT_EQ(held.size(), landmark.views.size());
    EXPECT_EQ(held.count(10 * (k + 1)), 1U) << "the newest view is always there";
    if (k == 1) {
      EXPECT_EQ(held, (std::set<int>{20}));
    }
  }
  EXPECT_EQ(map->landmarks[l.index()].views.size(), Landmark::kViews);
}

}  // namespace
}  // namespace polhode::map_test
