#include "tracks/track_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <type_traits>
#include <vector>

#include "spots.hpp"

namespace polhode::track_table_test {
namespace {

TEST(TrackTable, HasNoTracks_AfterOneFrame) {
  TrackedSpots f;
  f.add(range(0, 20));
  EXPECT_EQ(f.table->frames.size(), 1U);
  EXPECT_EQ(f.table->frames[0].frame, 100U);
  EXPECT_EQ(f.table->frames[0].timestamp_ns, 100000);
  EXPECT_EQ(f.table->frames[0].features.size(), 20U);
  EXPECT_TRUE(f.table->tracks.empty());
  f.expect_consistent();
}

TEST(TrackTable, ChainsASpotOverAllFrames_WhateverItsPlaceInTheList) {
  TrackedSpots f;
  f.add({0, 1, 2, 3, 4});
  f.add({4, 3, 2, 1, 0});
  f.add({2, 0, 4, 1, 3});
  ASSERT_EQ(f.table->tracks.size(), 5U);
  for (const Track& track : f.table->tracks) {
    EXPECT_EQ(track.points.size(), 3U);
  }
  f.expect_consistent();
}

// verifies: TRK-04
TEST(TrackTable, BridgesFiveMissedFrames_ButNotSix) {
  TrackedSpots f;
  f.add(range(0, 10));
  f.add(range(1, 10));
  for (int i = 0; i < 4; ++i) {
    f.add(range(2, 10));
  }
  f.add(range(0, 10));  // 0 was away for five frames
  const auto bridged = f.observations();
  EXPECT_EQ(bridged.at(0), (std::set<std::uint32_t>{100, 106}));
  EXPECT_EQ(bridged.at(1), (std::set<std::uint32_t>{100, 101, 106}));
  f.expect_consistent();
  TrackedSpots g;
  g.add(range(0, 10));
  for (int i = 0; i < 6; ++i) {
    g.add(range(1, 10));
  }
  g.add(range(0, 10));
  EXPECT_EQ(g.observations().count(0), 0U);
  g.expect_consistent();
}

TEST(TrackTable, TiesNothing_BetweenFramesWithoutCommonSpots) {
  TrackedSpots f;
  f.add(range(0, 20));
  f.add(range(20, 40));
  EXPECT_TRUE(f.table->tracks.empty());
  f.add({});
  EXPECT_TRUE(f.table->tracks.empty());
  f.expect_consistent();
}

TEST(TrackTable, ForgetsTheOldestFrame_AndTheTracksOfItAlone) {
  TrackedSpots f;
  f.add(range(0, 10));
  f.add(range(0, 8));
  f.add(range(0, 5));
  drop_oldest_frame(f.table.get());
  f.expect_consistent();
  ASSERT_EQ(f.table->frames.size(), 2U);
  EXPECT_EQ(f.table->frames[0].frame, 101U);
  const auto left = f.observations();
  EXPECT_EQ(left.at(0), (std::set<std::uint32_t>{101, 102}));
  EXPECT_EQ(left.at(7), (std::set<std::uint32_t>{101}));
  EXPECT_EQ(left.count(9), 0U);
  drop_oldest_frame(f.table.get());
  f.expect_consistent();
  EXPECT_EQ(f.observations().size(), 5U);
}

TEST(TrackTable, ForgetsWhatLeadsNowhere_WhenTheImageHasChanged) {
  TrackedSpots f;
  for (int i = 0; i < 6; ++i) {
    f.add(range(0, 20));  // one thing
  }
  for (int i = 0; i < 2; ++i) {
    f.add(range(40, 60));  // another
    drop_unconnected_frames(8, f.table.get());
    EXPECT_GE(f.table->frames.size(), 6U) << "the first one may come back";
  }
  f.add(range(40, 60));
  drop_unconnected_frames(8, f.table.get());
  ASSERT_EQ(f.table->frames.size(), 3U);
  EXPECT_EQ(f.table->frames[0].frame, 106U);
  EXPECT_EQ(f.observations().size(), 20U);
  f.expect_consistent();
}

TEST(TrackTable, KeepsWhatLeadsOn_OverTwoStrangeFrames) {
  TrackedSpots f;
  f.add(range(0, 20));
  f.add(range(0, 20));
  f.add(range(100, 120));
  f.add(range(120, 140));
  f.add(range(0, 20));
  drop_unconnected_frames(8, f.table.get());
  EXPECT_EQ(f.table->frames.size(), 5U);
  f.expect_consistent();
}

TEST(TrackTable, KeepsTheLastFrames_WhenMoreComeThanItHolds) {
  TrackedSpots f;
  constexpr int kFrames = static_cast<int>(limits::kInitialFrames) + 7;
  for (int i = 0; i < kFrames; ++i) {
    f.add(range(i, i + 20));  // each spot is seen in 20 frames
  }
  EXPECT_EQ(f.table->frames.size(), limits::kInitialFrames);
  EXPECT_EQ(f.table->frames[0].frame, 107U);
  EXPECT_EQ(f.table->frames.back().frame, static_cast<std::uint32_t>(100 + kFrames - 1));
  f.expect_consistent();
  for (const auto& [spot, frames] : f.observations()) {
    const int first = std::max(spot - 19, 7);
    const int last = std::min(spot, kFrames - 1);
    EXPECT_EQ(static_cast<int>(frames.size()), last - first + 1) << spot;
  }
}

TEST(TrackTable, StaysConsistent_UnderRandomObservations) {
  TrackedSpots f;
  Rng rng(42, 0);
  for (int i = 0; i < 60; ++i) {
    std::vector<int> spots;
    for (int s = 0; s < 60; ++s) {
      if (rng.uniform() < 0.6) {
        spots.push_back(s);
      }
    }
    for (std::size_t k = spots.size(); k > 1; --k) {
      std::swap(spots[k - 1], spots[rng.below(static_cast<std::uint32_t>(k))]);
    }
    f.add(spots);
    f.expect_consistent();
  }
}

TEST(TrackTable, MakesRoomForANewFrame_ByTheTracksThatEnded_TheShortestFirst) {
  TrackedSpots f;
  constexpr int kSpots = static_cast<int>(limits::kInitialTracks) / 5;
  const auto show = [&](int group) { f.add(range(group * kSpots, (group + 1) * kSpots)); };
  show(0);
  for (int group = 0; group < 5; ++group) {
    show(group);
    show(group);
  }
  for (int i = 0; i < 3; ++i) {
    show(4);  // the others were seen more than six frames ago
  }
  EXPECT_TRUE(f.table->tracks.full());
  show(5);
  show(5);
  f.expect_consistent();
  EXPECT_EQ(f.table->full_count, 0U);
  const auto left = f.observations();
  EXPECT_EQ(left.count(kSpots), 0U) << "two points, and ended";
  EXPECT_EQ(left.count(2 * kSpots), 0U) << "two points, and ended";
  EXPECT_EQ(left.count(0), 1U) << "ended, with three points";
  EXPECT_EQ(left.count(3 * kSpots), 0U) << "two points, and ended";
  EXPECT_EQ(left.count(4 * kSpots), 1U) << "may go on";
  EXPECT_EQ(left.count(5 * kSpots), 1U) << "new";
}

TEST(TrackTable, LosesNoTrackThatEnded_WhileThereIsRoom) {
  TrackedSpots f;
  constexpr int kSpots = static_cast<int>(limits::kInitialTracks) / 5;
  for (int group = 0; group < 5; ++group) {
    f.add(range(group * kSpots, (group + 1) * kSpots));
    f.add(range(group * kSpots, (group + 1) * kSpots));
  }
  EXPECT_EQ(f.table->tracks.size(), limits::kInitialTracks);
  EXPECT_EQ(f.table->full_count, 0U);
}

TEST(TrackTable, CountsTracksThatFindNoPlace_WhenItIsFullOfTracksThatMayGoOn) {
  TrackedSpots f;
  constexpr int kSpots = static_cast<int>(limits::kFeatures);
  constexpr auto kMade = static_cast<std::uint32_t>(2 * kSpots);
  static_assert(kMade > limits::kInitialTracks);
  for (int group = 0; group < 2; ++group) {
    f.add(range(group * kSpots, (group + 1) * kSpots));
    f.add(range(group * kSpots, (group + 1) * kSpots));
  }
  EXPECT_TRUE(f.table->tracks.full());
  EXPECT_EQ(f.table->full_count, kMade - limits::kInitialTracks);
  f.expect_consistent();
}

TEST(TrackTable, APointKnowsTheNearerLookOfThoseBesideIt) {
  TrackedSpots f;
  f.add(range(0, 4));
  f.add(range(0, 4), 4);
  f.add(range(0, 4), 10);
  f.add(range(0, 4), 13);
  ASSERT_EQ(f.table->tracks.size(), 4U);
  for (const Track& track : f.table->tracks) {
    ASSERT_EQ(track.points.size(), 4U);
    EXPECT_EQ(track.points[0].distance2, 4 * 4);
    EXPECT_EQ(track.points[1].distance2, 4 * 4) << "not the 6 * 6 to the one after it";
    EXPECT_EQ(track.points[2].distance2, 3 * 3);
    EXPECT_EQ(track.points[3].distance2, 3 * 3);
  }
}

TEST(TrackTable, IsEmptyAgain_AfterClear) {
  TrackedSpots f;
  f.add(range(0, 10));
  f.add(range(0, 10));
  clear(f.table.get());
  EXPECT_TRUE(f.table->frames.empty());
  EXPECT_TRUE(f.table->tracks.empty());
  f.add(range(0, 10));
  f.add(range(0, 10));
  EXPECT_EQ(f.table->tracks.size(), 10U);
  f.expect_consistent();
}

TEST(TrackTable, IsValid_UntilAnIndexOrAPlaceIsDamaged) {
  TrackedSpots f;
  EXPECT_TRUE(is_valid(*f.table)) << "empty";
  f.add(range(0, 12));
  f.add(range(0, 10));
  TrackTable& table = *f.table;
  ASSERT_EQ(table.tracks.size(), 10U);
  EXPECT_TRUE(is_valid(table));
  const auto expect_refused = [&](auto* value, double spoilt) {
    const auto good = *value;
    *value = static_cast<std::remove_const_t<decltype(good)>>(spoilt);
    EXPECT_FALSE(is_valid(table)) << spoilt;
    *value = good;
  };
  for (const double index : {-2.0, 12.0}) {
    expect_refused(&table.track_of[1][3], index);
    expect_refused(&table.tracks[9].points[1].frame, index);
    expect_refused(&table.tracks[9].points[1].feature, index);
  }
  for (const double place : {2e12, std::nan("")}) {
    expect_refused(&table.frames[0].features[11].normalised.x(), place);
  }
  table.track_of[1][10] = 77;  // of a feature that the frame does not have: never read
  EXPECT_TRUE(is_valid(table));
}

}  // namespace
}  // namespace polhode::track_table_test
