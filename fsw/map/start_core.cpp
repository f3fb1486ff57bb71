// Which frames and tracks a contest is held on.
#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "map/initialise.hpp"

namespace polhode {
namespace {

// An affine shape has 8 unknowns a frame and 3 a track: 12 tracks leave a third of the equations as a check.
constexpr int kCommonMin = 12;
// Frames with fewer tracks say nothing about a body of which we know nothing.
constexpr int kFrameTracksMin = 8;
// Past this many common tracks a longer run of frames is worth more than more tracks.
constexpr double kCommonEnough = 60.0;
// Tracks that each frame should have in the contest, when it has them.
constexpr int kFrameQuota = 24;

using FrameMask = std::uint32_t;
static_assert(limits::kStartFrames <= 32);

struct Run {
  FixedVector<int, limits::kStartFrames> frames;
  FrameMask mask = 0;
  double score = 0.0;
};

FrameMask mask_of(const StartTrack& track) {
  FrameMask mask = 0;
  for (const StartObservation& o : track.observations) {
    mask |= 1U << static_cast<unsigned>(o.frame);
  }
  return mask;
}

/// Frames with tracks enough, in order. A frame that lost most of its tracks would break every run through it.
FixedVector<int, limits::kStartFrames> live_frames(const StartProblem& problem) {
  std::array<int, limits::kStartFrames> counts{};
  for (const StartTrack& track : problem.tracks) {
    if (track.observations.size() >= 2) {
      for (const StartObservation& o : track.observations) {
        ++counts[static_cast<std::size_t>(o.frame)];
      }
    }
  }
  std::array<int, limits::kStartFrames> sorted = counts;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(problem.times_s.size());
  std::sort(sorted.begin(), end);
  const int median = sorted[problem.times_s.size() / 2];
  FixedVector<int, limits::kStartFrames> live;
  for (std::size_t f = 0; f < problem.times_s.size(); ++f) {
    if (counts[f] >= std::max(kFrameTracksMin, median / 3)) {
      (void)live.push_back(static_cast<int>(f));
    }
  }
  return live;
}

int count_common(const StartProblem& problem, FrameMask mask) {
  int count = 0;
  for (const StartTrack& track : problem.tracks) {
    count += (mask_of(track) & mask) == mask ? 1 : 0;
  }
  return count;
}

/// The run of live frames that has the largest product of length and root of tracks in common.
Run best_run(const StartProblem& problem) {
  const FixedVector<int, limits::kStartFrames> live = live_frames(problem);
  Run best;
  for (std::size_t begin = 0; begin < live.size(); ++begin) {
    Run run;
    for (std::size_t end = begin; end < live.size(); ++end) {
      run.mask |= 1U << static_cast<unsigned>(live[end]);
      (void)run.frames.push_back(live[end]);
      if (run.frames.size() < 3) {
        continue;
      }
      const int common = count_common(problem, run.mask);
      if (common < kCommonMin) {
        break;
      }
      run.score = static_cast<double>(run.frames.size() - 1) * std::sqrt(std::min<double>(common, kCommonEnough));
      if (run.score > best.score) {
        best = run;
      }
    }
  }
  return best;
}

const StartObservation* find_frame(const StartTrack& track, int frame) {
  const auto* const at = std::find_if(track.observations.begin(), track.observations.end(),
                                      [frame](const StartObservation& o) { return o.frame == frame; });
  return at == track.observations.end() ? nullptr : at;
}

using Distances = FixedVector<double, limits::kStartTracks>;

/// Takes the track that lies farthest from those taken, among those that `eligible` allows.
template <typename Eligible>
bool take_farthest(const StartProblem& problem, int frame, const Eligible& eligible, Distances* distance2,
                   StartContestSet* set) {
  double farthest = -1.0;
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < problem.tracks.size(); ++i) {
    if ((*distance2)[i] > farthest && eligible(i)) {
      farthest = (*distance2)[i];
      chosen = i;
    }
  }
  if (farthest < 0.0 || !set->tracks.push_back(static_cast<int>(chosen))) {
    return false;
  }
  const StartObservation* const taken = find_frame(problem.tracks[chosen], frame);
  (*distance2)[chosen] = -1.0;
  for (std::size_t i = 0; i < problem.tracks.size(); ++i) {
    const StartObservation* const other = find_frame(problem.tracks[i], frame);
    if (taken != nullptr && other != nullptr && (*distance2)[i] >= 0.0) {
      (*distance2)[i] = std::min((*distance2)[i], (taken->normalised - other->normalised).squaredNorm());
    }
  }
  return true;
}

/// Tracks outside the core, so that every frame has its quota.
void add_frame_quotas(const StartProblem& problem, StartContestSet* set) {
  std::array<int, limits::kStartFrames> counts{};
  FixedVector<std::uint8_t, limits::kStartTracks> taken;
  taken.resize(problem.tracks.size());
  const auto count = [&](int track) {
    taken[static_cast<std::size_t>(track)] = 1;
    for (const StartObservation& o : problem.tracks[static_cast<std::size_t>(track)].observations) {
      ++counts[static_cast<std::size_t>(o.frame)];
    }
  };
  std::for_each(set->tracks.begin(), set->tracks.end(), count);
  for (std::size_t n = set->tracks.size(); n < kContestTracks; ++n) {
    // The track that helps most frames short of their quota; the longer one, then the first, where several do.
    int best_gain = 0;
    int best_track = -1;
    for (std::size_t i = 0; i < problem.tracks.size(); ++i) {
      const StartTrack& track = problem.tracks[i];
      if (taken[i] != 0 || track.observations.size() < 2) {
        continue;
      }
      int gain = 0;
      for (const StartObservation& o : track.observations) {
        gain += counts[static_cast<std::size_t>(o.frame)] < kFrameQuota ? 100 : 1;
      }
      if (gain >= 100 && gain > best_gain) {
        best_gain = gain;
        best_track = static_cast<int>(i);
      }
    }
    if (best_track < 0) {
      return;
    }
    (void)set->tracks.push_back(best_track);
    count(best_track);
  }
}

void list_sightings(const StartProblem& problem, StartContestSet* set) {
  set->sightings.clear();
  set->core_sightings.clear();
  for (std::size_t k = 0; k < set->tracks.size(); ++k) {
    for (const StartObservation& o : problem.tracks[static_cast<std::size_t>(set->tracks[k])].observations) {
      const StartSighting s{.frame = o.frame,
                            .track = static_cast<int>(k),
                            .normalised = o.normalised,
                            .sigma_normalised = o.sigma_normalised};
      (void)set->sightings.push_back(s);
      const bool in_core = k < set->core.tracks &&
                           std::find(set->core.frames.begin(), set->core.frames.end(), o.frame) != set->core.frames.end();
      if (in_core) {
        (void)set->core_sightings.push_back(s);
      }
    }
  }
}

}  // namespace

bool select_contest_set(const StartProblem& problem, StartContestSet* set) {
  POLHODE_ASSERT(problem.times_s.size() <= limits::kStartFrames, problem.times_s.size());
  POLHODE_ASSERT(problem.tracks.size() <= limits::kStartTracks, problem.tracks.size());
  set->tracks.clear();
  set->core.frames.clear();
  const Run run = best_run(problem);
  if (run.frames.size() < 3) {
    return false;
  }
  const std::size_t frames = std::min(kCoreFrames, run.frames.size());
  FrameMask mask = 0;
  for (std::size_t k = 0; k < frames; ++k) {
    const int frame = run.frames[k * (run.frames.size() - 1) / (frames - 1)];
    (void)set->core.frames.push_back(frame);
    mask |= 1U << static_cast<unsigned>(frame);
  }
  const int middle = set->core.frames[frames / 2];
  Distances distance2;
  distance2.resize(problem.tracks.size());
  std::fill(distance2.begin(), distance2.end(), 1e300);
  const auto in_core = [&](std::size_t i) { return (mask_of(problem.tracks[i]) & mask) == mask; };
  while (set->tracks.size() < kCoreTracks && take_farthest(problem, middle, in_core, &distance2, set)) {
  }
  set->core.tracks = set->tracks.size();
  add_frame_quotas(problem, set);
  list_sightings(problem, set);
  return true;
}

}  // namespace polhode
