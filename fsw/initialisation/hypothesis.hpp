// A hypothesis of the geometry: poses of frames and points of tracks that explain the images.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "solve/initial_problem.hpp"

namespace polhode {

enum class HypothesisKind : std::uint8_t { kFivePoint, kHomography, kFactorisation, kConstantRate };
inline constexpr std::size_t kHypothesisKinds = 4;  // of the enumeration above

/// One kind as a bit of a mask.
constexpr std::uint32_t kind_bit(HypothesisKind kind) { return 1U << static_cast<unsigned>(kind); }
inline constexpr std::uint32_t kAllKinds = (1U << kHypothesisKinds) - 1U;  // one bit a kind

/// Tracks and frames of a core, in which every frame observes every track. Chosen: 80 tracks
/// separate families of hypotheses; 10 frames bound the time of the seeds.
inline constexpr std::size_t kCoreTracks = 80;
inline constexpr std::size_t kCoreFrames = 10;
/// The first tracks of the selection: both cores' and the quotas of frames. On them a hypothesis is
/// extended from its core to all frames; it is adjusted after every few frames, and need not decide
/// yet.
inline constexpr std::size_t kExtensionTracks = 2 * kCoreTracks;
/// Observations on which hypotheses are compared (of at most limits::kSelectionTracks); those of
/// the first tracks always count. Chosen for the time of an adjustment: 500 tracks in six frames of
/// eight.
inline constexpr std::size_t kSelectionObservations = 3000;

struct InitialHypothesis {
  HypothesisKind kind = HypothesisKind::kFivePoint;
  bool reversed = false;  ///< depth-reversed solution of a hypothesis of that kind
  std::size_t frames = 0;
  std::size_t tracks = 0;
  std::array<InverseDepthPose, limits::kInitialFrames> poses{};
  std::array<std::uint8_t, limits::kInitialFrames> posed{};
  std::array<Eigen::Vector3d, limits::kSelectionTracks> points_T{};
  std::array<std::uint8_t, limits::kSelectionTracks> known{};
  InitialFit fit;

  [[nodiscard]] InitialGeometryView view() {
    return {std::span(poses).first(frames),
            std::span(posed).first(frames),
            std::span(points_T).first(tracks),
            std::span(known).first(tracks)};
  }
};

/// Seeds of one core, rounded up from 21: 3 of factorisation, 4 of constant rate, and from each of
/// two pairs 3 of five points and 4 of homographies.
inline constexpr std::size_t kSeeds = 24;
using InitialHypotheses = FixedVector<InitialHypothesis, kSeeds>;
/// Hypotheses that are extended to all frames, shared by the cores. Chosen; more cost time.
inline constexpr std::size_t kFinalists = 6;

/// Input of a seed: frames of the sequence, and tracks of the selection that all of them observe.
struct InitialCore {
  FixedVector<int, kCoreFrames> frames;
  FixedVector<int, kCoreTracks> tracks;
};

}  // namespace polhode
