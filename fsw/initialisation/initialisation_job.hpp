// Hypothesis selection as a job: a snapshot of the tracks in, its outcome out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "config/limits.hpp"
#include "initialisation/align.hpp"
#include "initialisation/initialise.hpp"

namespace polhode {

struct InitialisationJob {
  std::size_t first_frame = 0;  ///< the problem's, in the table of tracks
  std::size_t frame_count = 0;
  std::size_t track_count = 0;
  std::array<double, limits::kInitialFrames> times_s{};
  std::array<Eigen::Matrix3d, limits::kInitialFrames> R_IC;
  std::array<InitialTrack, limits::kInitialTracks> tracks;
  std::uint64_t seed = 0;
  InitialOptions options;
  InitialImages images;
  AlignmentWorkspace alignment;
  InitialWorkspace workspace;
  InitialOutcome outcome;  ///< the result
};

/// A pure function of the job's snapshot.
void run_initialisation(InitialisationJob* job);

/// Instead of run_initialisation(), when there is no memory for it.
void skip_initialisation(InitialisationJob* job);

}  // namespace polhode
