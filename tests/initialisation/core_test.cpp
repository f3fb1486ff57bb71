// The set of tracks on which hypotheses are compared.
#include "initialisation/core.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <vector>

#include "base/rng.hpp"

namespace polhode::core_test {
namespace {

/// Tracks in the frames first .. first + length - 1.
void add_tracks(int count, int first, int length, std::vector<InitialTrack>* tracks) {
  Rng rng(32, tracks->size());
  for (int i = 0; i < count; ++i) {
    InitialTrack track;
    for (int f = first; f < first + length; ++f) {
      (void)track.observations.push_back({.frame = f,
                                          .normalised = {0.01 * rng.normal(), 0.01 * rng.normal()},
                                          .sigma_normalised = 1e-4});
    }
    tracks->push_back(track);
  }
}

struct Chosen {
  std::unique_ptr<SelectionSet> set = std::make_unique<SelectionSet>();
  std::vector<InitialTrack> tracks;
  std::vector<double> times_s;

  Chosen(std::vector<InitialTrack> of, int frames) : tracks(std::move(of)) {
    times_s.assign(static_cast<std::size_t>(frames), 0.0);
    EXPECT_TRUE(choose_selection_set(problem(), set.get()));
  }
  [[nodiscard]] InitialProblem problem() const { return {.times_s = times_s, .tracks = tracks}; }
  [[nodiscard]] std::size_t length_of(int track) const {
    return tracks[static_cast<std::size_t>(track)].observations.size();
  }
  /// Tracks of the set with so many images.
  [[nodiscard]] std::ptrdiff_t of_length(std::size_t length) const {
    return std::count_if(set->tracks.begin(), set->tracks.end(), [&](int track) {
      return length_of(track) == length;
    });
  }
};

void expect_consistent(const Chosen& c) {
  const std::set<int> once(c.set->tracks.begin(), c.set->tracks.end());
  EXPECT_EQ(once.size(), c.set->tracks.size()) << "a track twice";
  std::size_t observations = 0;
  for (std::size_t k = 0; k < c.set->tracks.size(); ++k) {
    if (k == kExtensionTracks) {
      EXPECT_EQ(c.set->extension_observations, observations);
    }
    observations += c.length_of(c.set->tracks[k]);
  }
  EXPECT_EQ(c.set->observations.size(), observations);
  if (c.set->tracks.size() <= kExtensionTracks) {
    EXPECT_EQ(c.set->extension_observations, observations);
  }
}

TEST(SelectionSet, TakesEveryTrackOfThreeImages_WhereThereIsRoom) {
  std::vector<InitialTrack> tracks;
  add_tracks(60, 0, 6, &tracks);
  add_tracks(70, 0, 4, &tracks);
  add_tracks(70, 3, 3, &tracks);
  const Chosen c(tracks, 6);
  expect_consistent(c);
  EXPECT_EQ(c.of_length(6), 60);
  EXPECT_EQ(c.of_length(4), 70);
  EXPECT_EQ(c.of_length(3), 70);
}

TEST(SelectionSet, TakesNoTrackOfTwoImages_BeyondTheQuotaOfAFrame) {
  std::vector<InitialTrack> tracks;
  add_tracks(200, 0, 2, &tracks);
  add_tracks(100, 0, 6, &tracks);
  add_tracks(1, 4, 1, &tracks);
  const Chosen c(tracks, 6);
  expect_consistent(c);
  EXPECT_EQ(c.of_length(6), 100);
  EXPECT_EQ(c.of_length(2), 0);
  EXPECT_EQ(c.of_length(1), 0);
}

TEST(SelectionSet, FillsUpWithTheLongestTracks) {
  const int of_each = static_cast<int>(limits::kSelectionTracks) / 2 + 40;
  std::vector<InitialTrack> tracks;
  add_tracks(of_each, 0, 4, &tracks);
  add_tracks(of_each, 0, 5, &tracks);
  const Chosen c(tracks, 5);
  expect_consistent(c);
  EXPECT_TRUE(c.set->tracks.full());
  EXPECT_EQ(c.of_length(5), of_each) << "all of them, though they are listed last";
}

TEST(SelectionSet, KeepsToItsObservations) {
  const auto frames = static_cast<int>(limits::kInitialFrames);
  std::vector<InitialTrack> tracks;
  add_tracks(static_cast<int>(limits::kSelectionTracks), 0, frames / 2, &tracks);
  const Chosen c(tracks, frames / 2);
  expect_consistent(c);
  EXPECT_FALSE(c.set->tracks.full());
  EXPECT_LE(c.set->observations.size(), kSelectionObservations);
  EXPECT_GT(c.set->observations.size(), kSelectionObservations - limits::kInitialFrames);
}

TEST(SelectionSet, HasTheTracksOfItsCoresFirst_ForTheExtension) {
  std::vector<InitialTrack> tracks;
  add_tracks(300, 2, 4, &tracks);
  add_tracks(100, 0, 6, &tracks);
  const Chosen c(tracks, 6);
  expect_consistent(c);
  ASSERT_FALSE(c.set->cores.empty());
  for (const InitialCore& core : c.set->cores) {
    for (const int track : core.tracks) {
      EXPECT_LT(track, static_cast<int>(kExtensionTracks));
    }
  }
  EXPECT_GT(c.set->tracks.size(), kExtensionTracks);
  EXPECT_LT(c.set->extension_observations, c.set->observations.size());
}

/// `per_frame` tracks begin in each frame and live for `length` frames.
bool crowded(int frames, int per_frame, int length) {
  std::vector<InitialTrack> tracks;
  for (int begin = 1 - length; begin < frames; ++begin) {
    const int first = std::max(0, begin);
    add_tracks(per_frame, first, std::min(frames, begin + length) - first, &tracks);
  }
  const Chosen c(tracks, frames);
  expect_consistent(c);
  return is_crowded(c.problem(), *c.set);
}

TEST(SelectionSet, IsCrowded_ByFramesWhoseTracksItHasNoPlaceFor) {
  EXPECT_FALSE(crowded(6, 20, 4));
  EXPECT_FALSE(crowded(24, 20, 4)) << "some 500 of three images and more";
  EXPECT_TRUE(crowded(24, 50, 4));
}

TEST(SelectionSet, IsCrowded_ByFramesWhoseObservationsItHasNoPlaceFor) {
  EXPECT_TRUE(crowded(28, 30, 9)) << "334 tracks of nine images are its observations";
}

TEST(SelectionSet, IsNotCrowded_WhereTracksLiveLong) { EXPECT_FALSE(crowded(32, 8, 24)); }

TEST(SelectionSet, IsNotCrowded_WhereThereAreNoMoreTracks) { EXPECT_FALSE(crowded(16, 7, 4)); }

}  // namespace
}  // namespace polhode::core_test
