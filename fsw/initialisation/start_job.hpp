// Hypothesis selection as a job: a snapshot of the tracks in, its outcome out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "config/limits.hpp"
#include "initialisation/align.hpp"
#include "initialisation/initialise.hpp"

namespace polhode {

struct StartJob {
  std::size_t first_frame = 0;  ///< the problem's, in the table of tracks
  std::size_t frame_count = 0;
  std::size_t track_count = 0;
  std::array<double, limits::kStartFrames> times_s{};
  std::array<Eigen::Matrix3d, limits::kStartFrames> R_IC;
  std::array<StartTrack, limits::kStartTracks> tracks;
  std::uint64_t seed = 0;
  StartOptions options;
  StartPictures pictures;
  AlignmentWorkspace alignment;
  StartWorkspace workspace;
  StartOutcome outcome;  ///< the result
};

/// A pure function of the job's snapshot.
void run_start(StartJob* job);

/// Instead of run_start(), when there is no memory for it.
void skip_start(StartJob* job);

}  // namespace polhode
