#include "decidability.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "initialisation/core.hpp"
#include "initialisation/extend.hpp"
#include "initialisation/selection.hpp"
#include "solve/initial_adjustment.hpp"

namespace polhode::benchmark {
namespace {

// As many as an affine shape needs to be checked by.
constexpr int kTracksMin = 12;

/// Distance over the size of the body in the first frame: true lengths over it are in extents.
double unit_of(const SelectionSet& set, const Pose& first) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double squares = 0.0;
  double count = 0.0;
  for (const TrackObservation& o : set.observations) {
    if (o.frame == set.observations[0].frame) {
      mean += o.normalised;
      squares += o.normalised.squaredNorm();
      count += 1.0;
    }
  }
  mean /= count;
  return first.p_CT.norm() * std::sqrt(std::max(1e-12, squares / count - mean.squaredNorm()));
}

InitialHypothesis true_geometry(const InitialProblem& problem,
                                std::span<const Pose> true_poses,
                                const SelectionSet& set) {
  InitialHypothesis h;
  h.frames = problem.times_s.size();
  h.tracks = set.tracks.size();
  const double unit = unit_of(set, true_poses[0]);
  for (std::size_t f = 0; f < h.frames; ++f) {
    h.poses[f] = to_inverse_depth({.R_CT = true_poses[f].R_CT, .p_CT = true_poses[f].p_CT / unit});
    h.posed[f] = 1;
  }
  add_points(set.observations.view(), &h);
  return h;
}

/// The images of the tracks that agree with a geometry, as it makes them.
std::vector<TrackObservation> without_noise(std::span<const TrackObservation> observations,
                                            const InitialAdjustmentOptions& options,
                                            InitialHypothesis* h,
                                            int* tracks) {
  std::vector<TrackObservation> images;
  for (std::size_t begin = 0; begin < observations.size();) {
    const std::size_t end = track_end(observations, begin);
    const auto track = static_cast<std::size_t>(observations[begin].track);
    const std::span run = observations.subspan(begin, end - begin);
    const bool agrees = h->known[track] != 0 && !track_cost(run, h->view(), options).wrong;
    if (agrees) {
      ++*tracks;
      for (TrackObservation o : run) {
        Eigen::Vector2d seen;
        if (reproject(h->poses[static_cast<std::size_t>(o.frame)], h->points_T[track], &seen)) {
          o.normalised = seen;
          images.push_back(o);
        }
      }
    } else {
      h->known[track] = 0;
    }
    begin = end;
  }
  return images;
}

}  // namespace

Decidability decide_by_truth(const InitialProblem& problem,
                             std::span<const Pose> true_poses,
                             InitialWorkspace* workspace) {
  Decidability out;
  SelectionSet& set = workspace->set;
  if (!choose_selection_set(problem, &set)) {
    return out;
  }
  InitialHypothesis truth = true_geometry(problem, true_poses, set);
  if (!normalise_gauge(truth.view())) {
    return out;
  }
  const InitialOptions options;  // no refinement asks for them
  Selection selection{.problem = problem, .options = options};
  // The poses are true; a track's place rests on its noisy images, and settles with them.
  InitialHypothesis settled = truth;
  (void)refine_to_minimum(selection, set.observations.view(), &workspace->adjustment, &settled);
  out.noise = settled.fit.noise_scale;
  selection.sigma_scale = std::clamp(out.noise, 1.0, kNoiseScaleMax);
  const InitialAdjustmentOptions loss = selection_loss(selection, 0);
  const std::vector<TrackObservation> images =
      without_noise(set.observations.view(), loss, &truth, &out.tracks);
  out.agreeing = static_cast<double>(out.tracks) / static_cast<double>(set.tracks.size());
  if (out.tracks < kTracksMin || !normalise_gauge(truth.view())) {
    return out;
  }
  InitialHypothesis reversed = truth;
  apply_depth_reversal(reversed.view());
  if (!normalise_gauge(reversed.view())) {
    return out;
  }
  const double truth_cost =
      evaluate_initial(images, truth.view(), loss, &workspace->adjustment).cost;
  (void)refine_to_minimum(selection, images, &workspace->adjustment, &reversed);
  out.margin = reversed.fit.cost - truth_cost;
  out.known = true;
  return out;
}

}  // namespace polhode::benchmark
