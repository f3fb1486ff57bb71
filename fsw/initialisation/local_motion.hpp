// Local image motion between two kept frames about a track, by its neighbouring tracks.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"

namespace polhode {

/// Places where a track was detected, by frame.
struct TrackPlaces {
  std::uint32_t frames = 0;  ///< bit f: in frame f
  std::array<Eigen::Vector2f, limits::kInitialFrames> px{};

  [[nodiscard]] bool has(std::size_t frame) const { return ((frames >> frame) & 1U) != 0; }
};

// Three times the neighbours that a fit needs: many end before the other frame.
using Neighbours = FixedVector<std::size_t, 36>;

/// Other tracks of a frame, nearest first.
Neighbours nearest_tracks(std::span<const TrackPlaces> tracks,
                          std::size_t track,
                          std::size_t frame);

struct LocalMotion {
  Eigen::Matrix2d affine = Eigen::Matrix2d::Identity();
  Eigen::Vector2d place_px = Eigen::Vector2d::Zero();  ///< where the track's place moves to
};

/// Affine motion of a track's neighbours, by a robust fit.
/// @return nothing where too few of them are in both frames.
std::optional<LocalMotion> local_motion(std::span<const TrackPlaces> tracks,
                                        const Neighbours& neighbours,
                                        std::size_t track,
                                        std::size_t from_frame,
                                        std::size_t to_frame);

}  // namespace polhode
