// Spots with looks of their own, and a table of the tracks over their images.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <set>
#include <vector>

#include "base/rng.hpp"
#include "tracks/track_table.hpp"

namespace polhode {

/// The look of spot `spot`: distinct bytes that any other spot's are far from.
inline Descriptor look_of(int spot) {
  Rng rng(41, static_cast<std::uint64_t>(spot));
  Descriptor d;
  for (std::uint8_t& byte : d) {
    byte = static_cast<std::uint8_t>(rng.below(2) * 90);  // norm near 720, two spots near 720 apart
  }
  return d;
}

struct TrackedSpots {
  std::unique_ptr<TrackTable> table = std::make_unique<TrackTable>();
  std::unique_ptr<Features> features = std::make_unique<Features>();
  RestingPlaces resting;
  std::uint32_t next_frame = 100;
  float moved_px = 0.0F;  ///< of the spots below kMoving, in the next frame
  static constexpr int kMoving = 60;

  /// A frame in which these spots are seen, in this order. @param change  of each look's first
  /// byte.
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
    add_frame({.frame = next_frame,
               .timestamp_ns = 1000 * static_cast<std::int64_t>(next_frame),
               .features = features.get()},
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

inline std::vector<int> range(int first, int last) {
  std::vector<int> spots;
  for (int i = first; i < last; ++i) {
    spots.push_back(i);
  }
  return spots;
}

}  // namespace polhode
