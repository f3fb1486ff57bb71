#include "initialisation/core.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"

namespace polhode {
namespace {

// An affine shape has 8 unknowns a frame and 3 a track, less 12 of the gauge. In three frames 12
// tracks leave a third of the equations as a check.
constexpr int kCommonMin = 12;
// Frames with fewer tracks are skipped. Chosen; larger drops frames that connect others, smaller
// keeps frames at which every run ends.
constexpr int kFrameTracksMin = 8;
// Least part of the median number of tracks in a frame: one over this. Chosen; every run would end
// at a frame that lost most of its tracks.
constexpr int kMedianPart = 3;
// Beyond this number of common tracks only a longer run of frames raises the score. Chosen.
constexpr double kCommonEnough = 60.0;
// Tracks that each frame should have in the selection, if it has them. Chosen: half again as many
// as kFrameTracksEnough.
constexpr int kFrameQuota = 60;
// Tracks of a frame that are enough. With 40 all runs of decision 0030 begin well; with 30 some
// begin wrongly, with 60 one late.
constexpr int kFrameTracksEnough = 40;
// Gain of a track in a frame short of its quota: it outweighs all other frames together.
constexpr int kShortFrameGain = 100;
static_assert(kShortFrameGain > static_cast<int>(limits::kInitialFrames));

using FrameMask = std::uint32_t;
static_assert(limits::kInitialFrames <= 32);

struct Run {
  FixedVector<int, limits::kInitialFrames> frames;
  FrameMask mask = 0;
  double score = 0.0;
};

FrameMask mask_of(const InitialTrack& track) {
  FrameMask mask = 0;
  for (const InitialObservation& o : track.observations) {
    mask |= 1U << static_cast<unsigned>(o.frame);
  }
  return mask;
}

using FrameCounts = std::array<int, limits::kInitialFrames>;

void count_frames(const InitialTrack& track, FrameCounts* counts) {
  for (const InitialObservation& o : track.observations) {
    ++(*counts)[static_cast<std::size_t>(o.frame)];
  }
}

/// Number of tracks in each frame that another frame observes too.
FrameCounts count_offered(const InitialProblem& problem) {
  FrameCounts counts{};
  for (const InitialTrack& track : problem.tracks) {
    if (track.observations.size() >= 2) {
      count_frames(track, &counts);
    }
  }
  return counts;
}

/// Frames with enough tracks, in order.
FixedVector<int, limits::kInitialFrames> live_frames(const InitialProblem& problem) {
  const FrameCounts counts = count_offered(problem);
  FrameCounts sorted = counts;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(problem.times_s.size());
  std::sort(sorted.begin(), end);
  const int median = sorted[problem.times_s.size() / 2];
  FixedVector<int, limits::kInitialFrames> live;
  for (std::size_t f = 0; f < problem.times_s.size(); ++f) {
    if (counts[f] >= std::max(kFrameTracksMin, median / kMedianPart)) {
      (void)live.push_back(static_cast<int>(f));
    }
  }
  return live;
}

int count_common(const InitialProblem& problem, FrameMask mask) {
  int count = 0;
  for (const InitialTrack& track : problem.tracks) {
    count += (mask_of(track) & mask) == mask ? 1 : 0;
  }
  return count;
}

double long_score(std::size_t frames, int common) {
  return static_cast<double>(frames - 1) * std::sqrt(std::min<double>(common, kCommonEnough));
}

/// On a body with many faces that rotates fast, all frames of a long run observe one flat face
/// only. So tracks count more here.
double crowded_score(std::size_t frames, int common) {
  return std::sqrt(static_cast<double>(frames - 1)) * std::min<double>(common, kCoreTracks);
}

/// The run of live frames with the highest score.
template <typename Score>
Run best_run(const InitialProblem& problem, const Score& score) {
  const FixedVector<int, limits::kInitialFrames> live = live_frames(problem);
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
      run.score = score(run.frames.size(), common);
      if (run.score > best.score) {
        best = run;
      }
    }
  }
  return best;
}

using Distances = FixedVector<double, limits::kInitialTracks>;

/// Takes the eligible track that lies farthest from those taken.
template <typename Eligible>
bool take_farthest(const InitialProblem& problem,
                   int frame,
                   const Eligible& eligible,
                   Distances* distance2,
                   SelectionSet* set) {
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
  const InitialObservation* const taken = find_frame(problem.tracks[chosen], frame);
  (*distance2)[chosen] = -1.0;
  for (std::size_t i = 0; i < problem.tracks.size(); ++i) {
    const InitialObservation* const other = find_frame(problem.tracks[i], frame);
    if (taken != nullptr && other != nullptr && (*distance2)[i] >= 0.0) {
      (*distance2)[i] =
          std::min((*distance2)[i], (taken->normalised - other->normalised).squaredNorm());
    }
  }
  return true;
}

using Taken = FixedVector<std::uint8_t, limits::kInitialTracks>;

/// by track: is it in the set?
Taken list_taken(const InitialProblem& problem, const SelectionSet& set) {
  Taken taken;
  taken.resize(problem.tracks.size());
  for (const int track : set.tracks) {
    taken[static_cast<std::size_t>(track)] = 1;
  }
  return taken;
}

/// Adds tracks outside the core until every frame has its quota.
void add_frame_quotas(const InitialProblem& problem, SelectionSet* set) {
  FrameCounts counts{};
  Taken taken = list_taken(problem, *set);
  for (const int track : set->tracks) {
    count_frames(problem.tracks[static_cast<std::size_t>(track)], &counts);
  }
  for (std::size_t n = set->tracks.size(); n < kExtensionTracks; ++n) {
    // The track that is in most frames short of their quota. Among equals the longest, then the
    // first.
    int best_gain = 0;
    int best_track = -1;
    for (std::size_t i = 0; i < problem.tracks.size(); ++i) {
      const InitialTrack& track = problem.tracks[i];
      if (taken[i] != 0 || track.observations.size() < 2) {
        continue;
      }
      int gain = 0;
      for (const InitialObservation& o : track.observations) {
        gain += counts[static_cast<std::size_t>(o.frame)] < kFrameQuota ? kShortFrameGain : 1;
      }
      if (gain >= kShortFrameGain && gain > best_gain) {
        best_gain = gain;
        best_track = static_cast<int>(i);
      }
    }
    if (best_track < 0) {
      return;
    }
    (void)set->tracks.push_back(best_track);
    taken[static_cast<std::size_t>(best_track)] = 1;
    count_frames(problem.tracks[static_cast<std::size_t>(best_track)], &counts);
  }
}

/// Up to limits::kSelectionTracks: all other tracks that constrain depth, the longest first.
void add_longest(const InitialProblem& problem, SelectionSet* set) {
  // Two images of a spot agree with either depth sign: the third is the first to decide.
  constexpr std::size_t kImagesMin = 3;
  const Taken taken = list_taken(problem, *set);
  std::size_t observations = 0;
  for (const int track : set->tracks) {
    observations += problem.tracks[static_cast<std::size_t>(track)].observations.size();
  }
  for (std::size_t length = problem.times_s.size(); length >= kImagesMin; --length) {
    for (std::size_t i = 0; i < problem.tracks.size(); ++i) {
      if (taken[i] != 0 || problem.tracks[i].observations.size() != length) {
        continue;
      }
      observations += length;
      if (observations > kSelectionObservations || !set->tracks.push_back(static_cast<int>(i))) {
        return;
      }
    }
  }
}

void list_observations(const InitialProblem& problem, SelectionSet* set) {
  set->observations.clear();
  set->extension_observations = 0;
  for (std::size_t k = 0; k < set->tracks.size(); ++k) {
    for (const InitialObservation& o :
         problem.tracks[static_cast<std::size_t>(set->tracks[k])].observations) {
      (void)set->observations.push_back({.frame = o.frame,
                                         .track = static_cast<int>(k),
                                         .normalised = o.normalised,
                                         .sigma_normalised = o.sigma_normalised});
    }
    if (k < kExtensionTracks) {
      set->extension_observations = set->observations.size();
    }
  }
}

/// Up to kCoreFrames of the run, evenly spaced, its ends included.
FrameMask choose_frames(const Run& run, InitialCore* core) {
  const std::size_t frames = std::min(kCoreFrames, run.frames.size());
  FrameMask mask = 0;
  core->frames.clear();
  for (std::size_t k = 0; k < frames; ++k) {
    const int frame = run.frames[k * (run.frames.size() - 1) / (frames - 1)];
    (void)core->frames.push_back(frame);
    mask |= 1U << static_cast<unsigned>(frame);
  }
  return mask;
}

/// Tracks observed in all of the core's frames: those in the set already, then more, spread over
/// the middle frame.
void choose_tracks(const InitialProblem& problem,
                   FrameMask mask,
                   std::size_t tracks_max,
                   SelectionSet* set,
                   InitialCore* core) {
  const auto sees_all = [&](std::size_t i) { return (mask_of(problem.tracks[i]) & mask) == mask; };
  Distances distance2;
  distance2.resize(problem.tracks.size());
  constexpr double kFar2 = 1e300;  // beyond every distance: no track is taken yet
  std::fill(distance2.begin(), distance2.end(), kFar2);
  for (const int taken : set->tracks) {
    distance2[static_cast<std::size_t>(taken)] = -1.0;
  }
  core->tracks.clear();
  for (std::size_t k = 0; k < set->tracks.size() && core->tracks.size() < tracks_max; ++k) {
    if (sees_all(static_cast<std::size_t>(set->tracks[k]))) {
      (void)core->tracks.push_back(static_cast<int>(k));
    }
  }
  const int middle = core->frames[core->frames.size() / 2];
  while (core->tracks.size() < tracks_max &&
         take_farthest(problem, middle, sees_all, &distance2, set)) {
    (void)core->tracks.push_back(static_cast<int>(set->tracks.size()) - 1);
  }
}

}  // namespace

bool choose_selection_set(const InitialProblem& problem, SelectionSet* set) {
  POLHODE_ASSERT(problem.times_s.size() <= limits::kInitialFrames, problem.times_s.size());
  POLHODE_ASSERT(problem.tracks.size() <= limits::kInitialTracks, problem.tracks.size());
  set->tracks.clear();
  set->cores.clear();
  const Run longest = best_run(problem, long_score);
  if (longest.frames.size() < 3) {
    return false;
  }
  const Run crowded = best_run(problem, crowded_score);
  for (const Run* run : {&longest, &crowded}) {
    if (run == &crowded && run->mask == longest.mask) {
      continue;
    }
    InitialCore core;
    const FrameMask mask = choose_frames(*run, &core);
    choose_tracks(problem, mask, kCoreTracks, set, &core);
    (void)set->cores.push_back(core);
  }
  add_frame_quotas(problem, set);
  add_longest(problem, set);
  list_observations(problem, set);
  return true;
}

bool is_crowded(const InitialProblem& problem, const SelectionSet& set) {
  // Full by either bound of add_longest().
  const bool full = set.tracks.full() ||
                    set.observations.size() + problem.times_s.size() > kSelectionObservations;
  if (!full) {
    return false;
  }
  const FrameCounts offered = count_offered(problem);
  FrameCounts taken{};
  for (const int track : set.tracks) {
    count_frames(problem.tracks[static_cast<std::size_t>(track)], &taken);
  }
  for (std::size_t f = 0; f < problem.times_s.size(); ++f) {
    if (taken[f] < kFrameTracksEnough && offered[f] >= kFrameTracksEnough) {
      return true;
    }
  }
  return false;
}

}  // namespace polhode
