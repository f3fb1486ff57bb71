// Tracks before there is a map: the same point of the body over several selected frames.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "features/match.hpp"
#include "features/resting.hpp"
#include "tracks/optical_flow.hpp"

namespace polhode {

/// A frame kept for the initialisation of the map, with its features.
struct CollectedFrame {
  std::uint32_t frame = 0;
  std::int64_t timestamp_ns = 0;
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();  ///< the observer's attitude at that time
  Features features;
};

struct TrackPoint {
  std::int32_t frame = -1;    ///< index into TrackTable::frames
  std::int32_t feature = -1;  ///< index into that frame's features
  /// Squared distance of its descriptor to the nearer of the track's points before and after it.
  std::int32_t distance2 = std::numeric_limits<std::int32_t>::max();
};

struct Track {
  FixedVector<TrackPoint, limits::kInitialFrames> points;  ///< ascending by frame
};

struct TrackTable {
  FixedVector<CollectedFrame, limits::kInitialFrames> frames;
  FixedVector<Track, limits::kInitialTracks> tracks;
  /// Track that ends in feature i of frame f, or -1.
  std::array<std::array<std::int32_t, limits::kFeatures>, limits::kInitialFrames> track_of{};
  FeatureMatches scratch;
  std::uint32_t full_count = 0;  ///< tracks that found no place
};

inline const Feature& feature_of(const TrackPoint& point, const TrackTable& table) {
  return table.frames[static_cast<std::size_t>(point.frame)]
      .features[static_cast<std::size_t>(point.feature)];
}

/// A frame whose features are on the target.
struct CollectibleFrame {
  std::uint32_t frame = 0;
  std::int64_t timestamp_ns = 0;
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();  ///< the observer's attitude
  const Features* features = nullptr;
};

/// Appends a frame (its features are copied). Associates its features with the tracks of the last
/// six frames by mutual best descriptors, nearest frame first. A full table drops its oldest
/// frame.
void add_frame(const CollectibleFrame& frame, double ratio_max, TrackTable* table);

/// Drops frame 0 and the tracks that have no other frame.
void drop_oldest_frame(TrackTable* table);

/// Drops the frames before the last three where fewer than `tracks_min` tracks connect them to
/// these: no initialisation can use both.
void drop_unconnected_frames(std::size_t tracks_min, TrackTable* table);

/// Drops the tracks that stay in place in the image while others move, and stores their places.
/// Where nothing moves they stay.
void drop_resting_tracks(TrackTable* table, RestingPlaces* resting);

void clear(TrackTable* table);

/// Sizes and indices within the tables, as long as no bit has flipped in memory.
bool is_valid(const TrackTable& table);

}  // namespace polhode
