#include "tracks/track_table.hpp"

#include <algorithm>

#include "base/median.hpp"
#include "base/validity.hpp"
#include "tracks/associate.hpp"

namespace polhode {
namespace {

// A point that is missed in up to five frames is found again (decision 0097). Each further
// frame costs another matching.
constexpr std::size_t kLookBack = 6;
// Frames without a track to the newest ones may show another body. Chosen: a body that is hidden
// for one or two frames is still the same.
constexpr std::size_t kConnected = 3;

/// Keeps the tracks for which `keeps` is true, in their order.
template <typename Keeps>
void keep_tracks(const Keeps& keeps, TrackTable* table) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < table->tracks.size(); ++i) {
    const Track& track = table->tracks[i];
    const bool stays = keeps(track);
    const auto renumbered = stays ? static_cast<std::int32_t>(kept) : -1;
    for (const TrackPoint& point : track.points) {
      table->track_of[static_cast<std::size_t>(point.frame)]
                     [static_cast<std::size_t>(point.feature)] = renumbered;
    }
    if (stays) {
      table->tracks[kept++] = table->tracks[i];
    }
  }
  table->tracks.resize(kept);
}

/// Makes room for an eighth of the table: removes ended tracks, the shortest first, as they
/// constrain the geometry least. Tracks of the newest frames stay.
void make_room(TrackTable* table) {
  constexpr std::size_t kWanted = limits::kInitialTracks / 8;  // at a time, so that it is seldom
  const auto first_alive =
      static_cast<std::int32_t>(table->frames.size()) - static_cast<std::int32_t>(kLookBack) - 1;
  for (std::size_t length = 2; length < limits::kInitialFrames; ++length) {
    if (table->tracks.size() + kWanted <= limits::kInitialTracks) {
      return;
    }
    keep_tracks(
        [&](const Track& track) {
          return track.points.size() > length || track.points.back().frame >= first_alive;
        },
        table);
  }
}

/// The track of a feature; a new one when it has none. -1 when the table is full.
/// @param may_make_room  tried once a frame.
std::int32_t track_for(std::size_t frame,
                       std::int32_t feature,
                       bool* may_make_room,
                       TrackTable* table) {
  std::int32_t& track = table->track_of[frame][static_cast<std::size_t>(feature)];
  if (track >= 0) {
    return track;
  }
  if (table->tracks.full() && *may_make_room) {
    make_room(table);
    *may_make_room = table->tracks.size() < limits::kInitialTracks;
  }
  Track fresh;
  (void)fresh.points.push_back({.frame = static_cast<std::int32_t>(frame), .feature = feature});
  if (!table->tracks.push_back(fresh)) {
    ++table->full_count;
    return -1;
  }
  track = static_cast<std::int32_t>(table->tracks.size()) - 1;
  return track;
}

void join(std::size_t earlier,
          std::size_t latest,
          double ratio_max,
          bool* may_make_room,
          TrackTable* table) {
  associate(table->frames[earlier].features.view(),
            table->frames[latest].features.view(),
            ratio_max,
            &table->scratch);
  for (const FeatureMatch& match : table->scratch) {
    std::int32_t& now = table->track_of[latest][static_cast<std::size_t>(match.b)];
    if (now >= 0) {
      continue;
    }
    const std::int32_t track = track_for(earlier, match.a, may_make_room, table);
    if (track < 0) {
      continue;
    }
    Track& t = table->tracks[static_cast<std::size_t>(track)];
    if (t.points.back().frame == static_cast<std::int32_t>(latest)) {
      continue;  // already associated with another feature of this frame
    }
    auto* const before = std::find_if(t.points.begin(), t.points.end(), [&](const TrackPoint& p) {
      return p.frame == static_cast<std::int32_t>(earlier);
    });
    before->distance2 = std::min(before->distance2, match.distance2);
    (void)t.points.push_back({.frame = static_cast<std::int32_t>(latest),
                              .feature = match.b,
                              .distance2 = match.distance2});
    now = track;
  }
}

/// Largest distance of a track's points from its first one.
double spread_px(const Track& track, const TrackTable& table) {
  const auto place = [&](const TrackPoint& point) {
    const Feature& f = feature_of(point, table);
    return Eigen::Vector2d(f.u_px, f.v_px);
  };
  double farthest_px = 0.0;
  for (const TrackPoint& point : track.points) {
    farthest_px = std::max(farthest_px, (place(point) - place(track.points[0])).norm());
  }
  return farthest_px;
}

}  // namespace

void clear(TrackTable* table) {
  table->frames.clear();
  table->tracks.clear();
}

void drop_oldest_frame(TrackTable* table) {
  table->frames.erase(0);
  for (std::size_t f = 0; f < table->frames.size(); ++f) {
    table->track_of[f] = table->track_of[f + 1];
  }
  for (Track& track : table->tracks) {
    if (track.points[0].frame == 0) {
      track.points.erase(0);
    }
    for (TrackPoint& point : track.points) {
      --point.frame;
    }
  }
  keep_tracks([](const Track& track) { return track.points.size() >= 1; }, table);
}

void drop_unconnected_frames(std::size_t tracks_min, TrackTable* table) {
  if (table->frames.size() <= kConnected) {
    return;
  }
  const auto first_late = static_cast<std::int32_t>(table->frames.size() - kConnected);
  std::size_t leading = 0;
  for (const Track& track : table->tracks) {
    leading +=
        track.points[0].frame < first_late && track.points.back().frame >= first_late ? 1 : 0;
  }
  if (leading >= tracks_min) {
    return;
  }
  while (table->frames.size() > kConnected) {
    drop_oldest_frame(table);
  }
}

void drop_resting_tracks(TrackTable* table, RestingPlaces* resting) {
  constexpr std::size_t kPoints = 3;  // two coincide by chance
  // Three sigma of a strong feature that is detected again in the same place. On a body, where its
  // axis meets the image, tracks move by 0.2 to 1 px.
  constexpr double kRest_px = 0.4;
  // Moving tracks, and their median motion, that show a rotating body. Chosen: as many as a window
  // of a selection needs (collect.cpp); more than the tracks of a slow body move.
  constexpr std::size_t kMovingMin = 40;
  // Too few for an initialisation by themselves, unless more places are known to rest.
  constexpr std::size_t kRestingMin = 12;
  constexpr double kMoves_px = 6.0;
  FixedVector<std::size_t, limits::kInitialTracks> at_rest;  // which of the tracks
  FixedVector<double, limits::kInitialTracks> moves_px;
  for (std::size_t t = 0; t < table->tracks.size(); ++t) {
    if (table->tracks[t].points.size() < kPoints) {
      continue;
    }
    const double spread = spread_px(table->tracks[t], *table);
    if (spread < kRest_px) {
      (void)at_rest.push_back(t);
    } else {
      (void)moves_px.push_back(spread);
    }
  }
  if (at_rest.size() + resting->places.size() < kRestingMin || moves_px.size() < kMovingMin ||
      median(std::span(moves_px.begin(), moves_px.size())) < kMoves_px) {
    return;
  }
  for (const std::size_t t : at_rest) {
    const Feature& latest = feature_of(table->tracks[t].points.back(), *table);
    add_place(latest.u_px, latest.v_px, resting);
  }
  // Shorter tracks at these places rest, too.
  keep_tracks(
      [&](const Track& track) {
        return !std::all_of(track.points.begin(), track.points.end(), [&](const TrackPoint& point) {
          const Feature& f = feature_of(point, *table);
          return is_resting(f.u_px, f.v_px, *resting);
        });
      },
      table);
}

void add_frame(const CollectibleFrame& frame, double ratio_max, TrackTable* table) {
  if (table->frames.full()) {
    drop_oldest_frame(table);
  }
  const std::size_t latest = table->frames.size();
  table->frames.resize(latest + 1);
  CollectedFrame& collected = table->frames[latest];
  collected.frame = frame.frame;
  collected.timestamp_ns = frame.timestamp_ns;
  collected.R_IC = frame.R_IC;
  collected.features = *frame.features;
  table->track_of[latest].fill(-1);
  bool may_make_room = true;
  for (std::size_t back = 1; back <= std::min(kLookBack, latest); ++back) {
    join(latest - back, latest, ratio_max, &may_make_room, table);
  }
}

bool is_valid(const TrackTable& table) {
  const auto in = [](std::int32_t index, std::size_t size) {
    return index >= 0 && static_cast<std::size_t>(index) < size;
  };
  if (table.frames.size() > table.frames.capacity() ||
      table.tracks.size() > table.tracks.capacity()) {
    return false;
  }
  for (std::size_t f = 0; f < table.frames.size(); ++f) {
    const Features& features = table.frames[f].features;
    if (features.size() > features.capacity()) {
      return false;
    }
    for (std::size_t i = 0; i < features.size(); ++i) {
      const std::int32_t track = table.track_of[f][i];
      if (!validity::is_bounded(features[i].normalised) ||
          (track != -1 && !in(track, table.tracks.size()))) {
        return false;
      }
    }
  }
  return std::all_of(table.tracks.begin(), table.tracks.end(), [&](const Track& track) {
    return track.points.size() <= track.points.capacity() &&
           std::all_of(track.points.begin(), track.points.end(), [&](const TrackPoint& point) {
             return in(point.frame, table.frames.size()) &&
                    in(point.feature,
                       table.frames[static_cast<std::size_t>(point.frame)].features.size());
           });
  });
}

}  // namespace polhode
