#include "pipeline/focal_job.hpp"

#include <algorithm>
#include <vector>

#include "base/sound.hpp"
#include "solve/bundle_part.hpp"

namespace polhode {
namespace {

template <typename From, typename To>
void copy(const From& from, To* to, std::size_t stride = 1) {
  to->clear();
  for (std::size_t i = 0; i < from.size(); i += stride) {
    (void)to->push_back(from[i]);
  }
}

/// Sizes and indices are such as they are prepared.
bool is_sound(const FocalJob& job) {
  const std::size_t poses = job.poses.size();
  const std::size_t points = job.points_T.size();
  const auto in = [](std::int32_t index, std::size_t count) {
    return index >= 0 && static_cast<std::size_t>(index) < count;
  };
  return poses <= job.poses.capacity() && points <= job.points_T.capacity() &&
         job.pose_fixed.size() == poses && job.observations.size() <= FocalJob::kObservations &&
         std::all_of(
             job.observations.begin(), job.observations.end(), [&](const BundleObservation& o) {
               return in(o.pose, poses) && in(o.point, points);
             });
}

}  // namespace

void prepare_focal(const BundleProblem& map, FocalJob* job) {
  const std::size_t stride = (map.poses.size() + FocalJob::kPoses - 1) / FocalJob::kPoses;
  copy(map.poses, &job->poses, stride);
  copy(map.pose_fixed, &job->pose_fixed, stride);
  std::vector<BundleObservation> observations;
  for (BundleObservation o : map.observations) {
    if (o.pose % static_cast<std::int32_t>(stride) == 0) {
      o.pose /= static_cast<std::int32_t>(stride);
      observations.push_back(o);
    }
  }
  const BundlePart part({.poses = job->poses.view(),
                         .pose_fixed = job->pose_fixed.view(),
                         .points_T = map.points_T,
                         .point_fixed = map.point_fixed,
                         .observations = observations},
                        FocalJob::kObservations);
  copy(part.problem().points_T, &job->points_T);
  copy(part.problem().observations, &job->observations);
  job->report = {};
}

void run_focal(FocalJob* job) {
  // With a right focal length half as many settle an adjusted map; one that was 30 % too long was
  // not settled by 20 on the sample, and the test decided nothing.
  constexpr BundleOptions kOptions{.iterations_max = 30, .cauchy_sigma = 2.0};
  job->report = {};
  if (is_sound(*job)) {  // else damaged in memory while it waited
    job->report = adjust_focal({.poses = job->poses.view(),
                                .pose_fixed = job->pose_fixed.view(),
                                .points_T = job->points_T.view(),
                                .point_fixed = {},
                                .observations = job->observations.view()},
                               kOptions);
  }
}

void take_focal(const FocalReport& report, FocalState* state) {
  if (refutes_focal(report) || bears_focal_out(report)) {
    state->found = report;
  }
}

bool is_sound(const FocalState& state) {
  const FocalReport& found = state.found;
  return sound::is_bool(state.waits) && sound::is_bool(found.usable) &&
         sound::is_at_least(found.factor, 0.0) && found.factor > 0.0 &&
         sound::is_at_least(found.relative_sigma, 0.0) &&
         sound::is_at_least(found.cost_as_given, 0.0) &&
         sound::is_at_least(found.cost_at_factor, 0.0);
}

}  // namespace polhode
