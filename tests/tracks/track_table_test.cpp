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

#include "base/rng.hpp"

namespace polhode {
namespace {

/// The look of spot `spot`: distinct octets that any other spot's are far from.
Descriptor look_of(int spot) {
  Rng rng(41, static_cast<std::uint64_t>(spot));
  Descriptor d;
  for (std::uint8_t& octet : d) {
    octet =
        static_cast<std::uint8_t>(rng.below(2) * 90);  // norm near 720, two spots near 720 apart
  }
  return d;
}

struct Fixture {
  std::unique_ptr<TrackTable> table = std::make_unique<TrackTable>();
  std::unique_ptr<Features> features = std::make_unique<Features>();
  std::uint32_t next_frame = 100;
  float moved_px = 0.0F;  ///< of the spots below kMoving, in the next frame
  static constexpr int kMoving = 60;

  /// A frame in which these spots are seen, in this order. @param change  of each look's first
  /// octet.
  void add(const std::vector<int>& spots, int change = 0) {
    features->clear();
    for (const int spot : spots) {
      Feature f;
      f.u_px = 10.0F * static_cast<float>(spot % 60) + 0.25F;
      f.v_px = 10.0F * static_cast<float>(spot / 60) + 0.75F + (spot < kMoving ? moved_px : 0.0F);
      f.scale_px = static_cast<float>(spot);
      f.descriptor = look_of(spot);
      f.descriptor[0] = static_cast<std::uint8_t>(f.descriptor[0] + change);
      ASSERT_TRUE(features->push_back(f));
    }
    add_frame(next_frame,
              1000 * static_cast<std::int64_t>(next_frame),
              Eigen::Matrix3d::Identity(),
              *features,
              0.8,
              table.get());
    ++next_frame;
  }

  int spot_of(const TrackPoint& point) const {
    const auto& collected = table->frames[static_cast<std::size_t>(point.frame)];
    return static_cast<int>(collected.features[static_cast<std::size_t>(point.feature)].scale_px);
  }

  /// What holds at any time: ascending frames, one spot a track, and track_of as the tracks'
  /// inverse.
  void expect_consistent() const {
    std::map<std::pair<int, int>, int> owner;
    for (std::size_t t = 0; t < table->tracks.size(); ++t) {
      const Track& track = table->tracks[t];
      ASSERT_GE(track.points.size(), 1U);
      for (std::size_t i = 0; i < track.points.size(); ++i) {
        ASSERT_GE(track.points[i].frame, 0);
        ASSERT_LT(track.points[i].frame, static_cast<std::int32_t>(table->frames.size()));
        if (i > 0) {
          ASSERT_GT(track.points[i].frame, track.points[i - 1].frame);
        }
        ASSERT_EQ(spot_of(track.points[i]), spot_of(track.points[0]));
        const auto inserted = owner.emplace(
            std::pair{track.points[i].frame, track.points[i].feature}, static_cast<int>(t));
        ASSERT_TRUE(inserted.second) << "one feature in two tracks";
      }
    }
    for (std::size_t f = 0; f < table->frames.size(); ++f) {
      for (std::size_t i = 0; i < table->frames[f].features.size(); ++i) {
        const auto found = owner.find({static_cast<int>(f), static_cast<int>(i)});
        ASSERT_EQ(table->track_of[f][i], found == owner.end() ? -1 : found->second);
      }
    }
  }

  /// Frames (as numbered by the caller) in which the track of each spot has a point.
  std::map<int, std::set<std::uint32_t>> observations() const {
    std::map<int, std::set<std::uint32_t>> out;
    for (const Track& track : table->tracks) {
      for (const TrackPoint& point : track.points) {
        out[spot_of(point)].insert(table->frames[static_cast<std::size_t>(point.frame)].frame);
      }
    }
    return out;
  }
};

std::vector<int> range(int first, int last) {
  std::vector<int> spots;
  for (int i = first; i < last; ++i) {
    spots.push_back(i);
  }
  return spots;
}

TEST(TrackTable, HasNoTracks_AfterOneFrame) {
  Fixture f;
  f.add(range(0, 20));
  EXPECT_EQ(f.table->frames.size(), 1U);
  EXPECT_EQ(f.table->frames[0].frame, 100U);
  EXPECT_EQ(f.table->frames[0].timestamp_ns, 100000);
  EXPECT_EQ(f.table->frames[0].features.size(), 20U);
  EXPECT_TRUE(f.table->tracks.empty());
  f.expect_consistent();
}

TEST(TrackTable, ChainsASpotOverAllFrames_WhateverItsPlaceInTheList) {
  Fixture f;
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
  Fixture f;
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
  Fixture g;
  g.add(range(0, 10));
  for (int i = 0; i < 6; ++i) {
    g.add(range(1, 10));
  }
  g.add(range(0, 10));
  EXPECT_EQ(g.observations().count(0), 0U);
  g.expect_consistent();
}

TEST(TrackTable, TiesNothing_BetweenFramesWithoutCommonSpots) {
  Fixture f;
  f.add(range(0, 20));
  f.add(range(20, 40));
  EXPECT_TRUE(f.table->tracks.empty());
  f.add({});
  EXPECT_TRUE(f.table->tracks.empty());
  f.expect_consistent();
}

TEST(TrackTable, ForgetsTheOldestFrame_AndTheTracksOfItAlone) {
  Fixture f;
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

TEST(TrackTable, ForgetsWhatLeadsNowhere_WhenThePictureHasChanged) {
  Fixture f;
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
  Fixture f;
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
  Fixture f;
  constexpr int kFrames = static_cast<int>(limits::kStartFrames) + 7;
  for (int i = 0; i < kFrames; ++i) {
    f.add(range(i, i + 20));  // each spot is seen in 20 frames
  }
  EXPECT_EQ(f.table->frames.size(), limits::kStartFrames);
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
  Fixture f;
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
  Fixture f;
  constexpr int kSpots = static_cast<int>(limits::kStartTracks) / 5;
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
  Fixture f;
  constexpr int kSpots = static_cast<int>(limits::kStartTracks) / 5;
  for (int group = 0; group < 5; ++group) {
    f.add(range(group * kSpots, (group + 1) * kSpots));
    f.add(range(group * kSpots, (group + 1) * kSpots));
  }
  EXPECT_EQ(f.table->tracks.size(), limits::kStartTracks);
  EXPECT_EQ(f.table->full_count, 0U);
}

TEST(TrackTable, CountsTracksThatFindNoPlace_WhenItIsFullOfTracksThatMayGoOn) {
  Fixture f;
  constexpr int kSpots = static_cast<int>(limits::kFeatures);
  constexpr auto kMade = static_cast<std::uint32_t>(2 * kSpots);
  static_assert(kMade > limits::kStartTracks);
  for (int group = 0; group < 2; ++group) {
    f.add(range(group * kSpots, (group + 1) * kSpots));
    f.add(range(group * kSpots, (group + 1) * kSpots));
  }
  EXPECT_TRUE(f.table->tracks.full());
  EXPECT_EQ(f.table->full_count, kMade - limits::kStartTracks);
  f.expect_consistent();
}

TEST(TrackTable, APointKnowsTheNearerLookOfThoseBesideIt) {
  Fixture f;
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

/// Frames in which 60 spots move by so much from each to the next, and 20 stay where they are.
void add_resting_and_moving(float step_px, int frames, Fixture* f) {
  std::vector<int> spots(80);
  std::iota(spots.begin(), spots.end(), 0);
  for (int frame = 0; frame < frames; ++frame) {
    f->add(spots);
    f->moved_px += step_px;
  }
}

std::size_t resting_tracks(const Fixture& f) {
  return static_cast<std::size_t>(
      std::count_if(f.table->tracks.begin(), f.table->tracks.end(), [&](const Track& track) {
        return f.spot_of(track.points[0]) >= Fixture::kMoving;
      }));
}

TEST(DropRestingTracks, DropsWhatStays_WhereOthersMove) {
  Fixture f;
  add_resting_and_moving(4.0F, 3, &f);
  ASSERT_EQ(resting_tracks(f), 20U);
  drop_resting_tracks(f.table.get());
  EXPECT_EQ(resting_tracks(f), 0U);
  EXPECT_EQ(f.table->tracks.size(), 60U);
  f.expect_consistent();
  add_resting_and_moving(4.0F, 1, &f);
  f.expect_consistent();
}

TEST(DropRestingTracks, KeepsThem_WhereHardlyAnythingMoves) {
  Fixture f;
  add_resting_and_moving(0.5F, 5, &f);  // a slow body
  drop_resting_tracks(f.table.get());
  EXPECT_EQ(f.table->tracks.size(), 80U);
}

TEST(DropRestingTracks, KeepsThem_UntilThreePointsTell) {
  Fixture f;
  add_resting_and_moving(9.0F, 2, &f);
  drop_resting_tracks(f.table.get());
  EXPECT_EQ(f.table->tracks.size(), 80U);
}

TEST(TrackTable, IsEmptyAgain_AfterClear) {
  Fixture f;
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

TEST(TrackTable, IsSound_UntilAnIndexOrAPlaceIsDamaged) {
  Fixture f;
  EXPECT_TRUE(is_sound(*f.table)) << "empty";
  f.add(range(0, 12));
  f.add(range(0, 10));
  TrackTable& table = *f.table;
  ASSERT_EQ(table.tracks.size(), 10U);
  EXPECT_TRUE(is_sound(table));
  const auto expect_refused = [&](auto* value, double spoilt) {
    const auto good = *value;
    *value = static_cast<std::remove_const_t<decltype(good)>>(spoilt);
    EXPECT_FALSE(is_sound(table)) << spoilt;
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
  EXPECT_TRUE(is_sound(table));
}

}  // namespace
}  // namespace polhode
