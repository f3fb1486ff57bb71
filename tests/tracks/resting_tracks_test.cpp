// Tracks that stay where they are while others move.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "spots.hpp"
#include "tracks/track_table.hpp"

namespace polhode::resting_tracks_test {
namespace {

/// Frames in which 60 spots move by so much from each to the next, and 20 stay where they are.
void add_resting_and_moving(float step_px, int frames, TrackedSpots* f) {
  std::vector<int> spots(80);
  std::iota(spots.begin(), spots.end(), 0);
  for (int frame = 0; frame < frames; ++frame) {
    f->add(spots);
    f->moved_px += step_px;
  }
}

std::size_t resting_tracks(const TrackedSpots& f) {
  return static_cast<std::size_t>(
      std::count_if(f.table->tracks.begin(), f.table->tracks.end(), [&](const Track& track) {
        return f.spot_of(track.points[0]) >= TrackedSpots::kMoving;
      }));
}

TEST(DropRestingTracks, DropsWhatStays_WhereOthersMove) {
  TrackedSpots f;
  add_resting_and_moving(4.0F, 3, &f);
  ASSERT_EQ(resting_tracks(f), 20U);
  drop_resting_tracks(f.table.get(), &f.resting);
  EXPECT_EQ(resting_tracks(f), 0U);
  EXPECT_EQ(f.table->tracks.size(), 60U);
  f.expect_consistent();
  add_resting_and_moving(4.0F, 1, &f);
  f.expect_consistent();
}

TEST(DropRestingTracks, KeepsThem_WhereHardlyAnythingMoves) {
  TrackedSpots f;
  add_resting_and_moving(0.5F, 5, &f);  // a slow body
  drop_resting_tracks(f.table.get(), &f.resting);
  EXPECT_EQ(f.table->tracks.size(), 80U);
}

TEST(DropRestingTracks, KeepsThem_UntilThreePointsTell) {
  TrackedSpots f;
  add_resting_and_moving(9.0F, 2, &f);
  drop_resting_tracks(f.table.get(), &f.resting);
  EXPECT_EQ(f.table->tracks.size(), 80U);
}

TEST(DropRestingTracks, RemembersThePlaces) {
  TrackedSpots f;
  add_resting_and_moving(4.0F, 3, &f);
  drop_resting_tracks(f.table.get(), &f.resting);
  EXPECT_EQ(f.resting.places.size(), 20U);
}

TEST(DropRestingTracks, DropsFewAndShortOnes_OnceMuchIsKnownToRest) {
  TrackedSpots f;
  add_resting_and_moving(4.0F, 3, &f);
  drop_resting_tracks(f.table.get(), &f.resting);
  add_resting_and_moving(4.0F, 1, &f);  // tracks of two points and more begin at the places again
  ASSERT_GT(resting_tracks(f), 0U);
  drop_resting_tracks(f.table.get(), &f.resting);
  EXPECT_EQ(resting_tracks(f), 0U);
  EXPECT_EQ(f.resting.places.size(), 20U);
  f.expect_consistent();
}

}  // namespace
}  // namespace polhode::resting_tracks_test
