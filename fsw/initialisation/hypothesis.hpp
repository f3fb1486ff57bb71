// A hypothesis of the geometry: poses of frames and points of tracks that explain the images.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "solve/start_problem.hpp"

namespace polhode {

enum class HypothesisKind : std::uint8_t { kFivePoint, kHomography, kFactorisation, kConstantRate };
inline constexpr std::size_t kHypothesisKinds = 4;

/// One kind as a bit of a mask.
constexpr std::uint32_t kind_bit(HypothesisKind kind) { return 1U << static_cast<unsigned>(kind); }
inline constexpr std::uint32_t kAllKinds = (1U << kHypothesisKinds) - 1U;

/// Tracks that hypotheses are compared on: past this the gap between them grows as N while its
/// error grows as sqrt(N).
inline constexpr std::size_t kContestTracks = 128;
/// Tracks and frames of the core, which sees every track in every frame.
inline constexpr std::size_t kCoreTracks = 80;
inline constexpr std::size_t kCoreFrames = 10;

struct StartHypothesis {
  HypothesisKind kind = HypothesisKind::kFivePoint;
  bool reversed = false;  ///< the depth-reversed twin of what that kind found
  std::size_t frames = 0;
  std::size_t tracks = 0;
  std::array<InverseDepthPose, limits::kStartFrames> poses{};
  std::array<std::uint8_t, limits::kStartFrames> posed{};
  std::array<Eigen::Vector3d, kContestTracks> points_T{};
  std::array<std::uint8_t, kContestTracks> known{};
  StartFit fit;

  [[nodiscard]] StartGeometryView view() {
    return {std::span(poses).first(frames),
            std::span(posed).first(frames),
            std::span(points_T).first(tracks),
            std::span(known).first(tracks)};
  }
};

/// Seeds of one core: 3 + 4 + 3 x 2 + 4 x 2 of the four kinds.
inline constexpr std::size_t kSeeds = 24;
using StartHypotheses = FixedVector<StartHypothesis, kSeeds>;

/// What a seed is made from: frames of the sequence, and contest tracks that all of them see.
struct StartCore {
  FixedVector<int, kCoreFrames> frames;
  FixedVector<int, kCoreTracks> tracks;
};

}  // namespace polhode
