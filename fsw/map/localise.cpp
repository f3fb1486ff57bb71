#include "map/localise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/avx2_dispatch.hpp"

namespace polhode {
namespace {

// Past 70 deg from its mean viewing direction a spot is foreshortened to a third and its descriptor
// no longer matches.
constexpr double kFacingCosineMin = 0.342;

int distance_to_views(const Landmark& landmark, const Feature& feature) {
  int best = std::numeric_limits<int>::max();
  for (const LandmarkView& view : landmark.views) {
    best = std::min(best, distance2(view.descriptor, feature.descriptor));
  }
  return best;
}

/// The predicted blob radius and the feature's agree within a factor of 2 (an octave).
bool scale_agrees(double predicted_px, const Feature& feature) {
  const double ratio = static_cast<double>(feature.scale_px) / predicted_px;
  return ratio > 0.5 && ratio < 2.0;
}

/// Where a landmark's blob is looked for, and of what radius it should be.
struct ExpectedBlob {
  Eigen::Vector2d pixel;
  double within_px = 0.0;
  double size_px = 0.0;
};

NearestFeature best_candidate(const Features& features,
                              const Landmark& landmark,
                              const ExpectedBlob& blob,
                              const FeatureGrid& grid) {
  std::array<std::int32_t, 256> near{};
  const std::size_t count = grid.find(blob.pixel.x(), blob.pixel.y(), blob.within_px, near);
  NearestFeature best;
  for (std::size_t k = 0; k < count; ++k) {
    const Feature& feature = features[static_cast<std::size_t>(near[k])];
    if (!scale_agrees(blob.size_px, feature)) {
      continue;
    }
    keep_nearest(
        near[k], distance_to_views(landmark, feature), features.view(), kSamePlace_px, &best);
  }
  return best;
}

void add_match(const LocaliseInput& input,
               std::size_t landmark,
               std::int32_t feature,
               LandmarkMatches* matches) {
  const Feature& f = (*input.features)[static_cast<std::size_t>(feature)];
  (void)matches->push_back({.landmark = LandmarkId::from_index(landmark),
                            .feature = feature,
                            .u_px = f.u_px,
                            .v_px = f.v_px,
                            .normalised = f.normalised,
                            .sigma_px = static_cast<double>(f.sigma_px),
                            .inlier = false});
}

bool takes_part(const LocaliseInput& input, const Landmark& landmark) {
  return landmark.used && (input.age == LandmarkAge::kAny || is_old(landmark, *input.map));
}

void to_observations(const LocaliseInput& input,
                     const LandmarkMatches& matches,
                     LocaliseScratch* scratch) {
  scratch->observations.clear();
  for (const LandmarkMatch& match : matches) {
    const Landmark& landmark = input.map->landmarks[match.landmark.index()];
    // A landmark determined by n observations adds 1/n of their variance to this frame's residual.
    const double own = 1.0 / std::max(1, landmark.observations);
    (void)scratch->observations.push_back(
        {.p_T = landmark.p_T,
         .normalised = match.normalised,
         .sigma_normalised = match.sigma_px * std::sqrt(1.0 + own) / input.camera->focal_px()});
  }
}

std::span<std::uint8_t> flags(LocaliseScratch* scratch) {
  return std::span(scratch->inlier).first(scratch->observations.size());
}

void mark(const LocaliseScratch& scratch, LandmarkMatches* matches) {
  for (std::size_t i = 0; i < matches->size(); ++i) {
    (*matches)[i].inlier = scratch.inlier[i] != 0;
  }
}

/// Reach of the pose's 3-sigma error at the edge of the body, in pixels.
double reach_px(const LocaliseInput& input, const AbsolutePose& absolute) {
  const double depth = std::max(absolute.pose.p_CT.z(), 1e-9);
  const double turn_rad =
      std::sqrt(absolute.covariance.topLeftCorner<3, 3>().diagonal().maxCoeff());
  const double shift =
      std::sqrt(absolute.covariance.bottomRightCorner<3, 3>().diagonal().head<2>().maxCoeff());
  const double sigma_px =
      (turn_rad * input.map->radius_mu + shift) * input.camera->focal_px() / depth;
  return std::max(input.options->search_floor_px, 3.0 * sigma_px);
}

Result<bool> solve_all(const LocaliseInput& input,
                       const Pose* hint,
                       LocaliseScratch* scratch,
                       LocalisedFrame* out) {
  // With enough confirmed landmarks only those determine the pose; the others are classified by it.
  const auto first_unconfirmed = std::stable_partition(
      out->matches.begin(), out->matches.end(), [&](const LandmarkMatch& match) {
        return confirmed(input.map->landmarks[match.landmark.index()]);
      });
  const auto confirmed_count = first_unconfirmed - out->matches.begin();
  to_observations(input, out->matches, scratch);
  const auto all = scratch->observations.view();
  const auto deciding = confirmed_count >= kConfirmedAlone
                            ? all.first(static_cast<std::size_t>(confirmed_count))
                            : all;
  const AbsolutePoseOptions options{.iterations_max = input.options->ransac_iterations_max,
                                    .inliers_min = input.options->inliers_min,
                                    .seed = input.seed,
                                    .stream = input.stream};
  const Result<AbsolutePose> pose =
      absolute_pose(deciding, hint, options, flags(scratch).first(deciding.size()));
  if (!pose) {
    return pose.error();
  }
  out->absolute = pose.value();
  out->absolute.inliers = mark_inliers(out->absolute.pose, all, flags(scratch));
  mark(*scratch, &out->matches);
  return true;
}

struct Agreement {
  std::ptrdiff_t inliers = 0;
  std::ptrdiff_t matches = 0;
  [[nodiscard]] double part() const {
    return static_cast<double>(inliers) / static_cast<double>(std::max<std::ptrdiff_t>(1, matches));
  }
};

/// Drops the matches of a revisited aspect unless they agree half as well as those of the young
/// one, and beyond chance. With the drift since, a landmark projects into the gate of a wrong
/// feature by chance (one in 16, in the smallest circle). Such matches would fix the drift.
bool drop_old_face_that_disagrees(const Map& map, LandmarkMatches* matches) {
  constexpr std::ptrdiff_t kInliersMin = 8;  // of an aspect: with fewer the rule below is noise
  constexpr std::ptrdiff_t kYoungMin = 20;   // fewer are no basis for a comparison
  constexpr double kChance = 1.0 / 16.0;     // of a wrong feature to fall within the gate
  Agreement old_face;
  Agreement young;
  const auto is_of_old_face = [&](const LandmarkMatch& match) {
    return is_old(map.landmarks[match.landmark.index()], map);
  };
  for (const LandmarkMatch& match : *matches) {
    Agreement& face = is_of_old_face(match) ? old_face : young;
    ++face.matches;
    face.inliers += match.inlier ? 1 : 0;
  }
  const double part_min =
      std::max(2.0 * kChance, young.matches < kYoungMin ? 4.0 * kChance : 0.5 * young.part());
  if (old_face.matches == 0 || (old_face.inliers >= kInliersMin && old_face.part() >= part_min)) {
    return false;
  }
  matches->resize(static_cast<std::size_t>(
      std::remove_if(matches->begin(), matches->end(), is_of_old_face) - matches->begin()));
  return true;
}

Result<bool> polish(const LocaliseInput& input,
                    const AbsolutePose& first,
                    LocaliseScratch* scratch,
                    LocalisedFrame* out) {
  match_about(input, first.pose, reach_px(input, first), scratch, out);
  return solve_matched(input, &first.pose, scratch, out);
}

}  // namespace

void match_about(const LocaliseInput& input,
                 const Pose& pose,
                 double radius_px,
                 LocaliseScratch* scratch,
                 LocalisedFrame* out) {
  scratch->grid.build(input.features->view(), input.camera->width_px, input.camera->height_px);
  // One feature to one landmark: of several candidates the nearest in appearance is matched.
  scratch->landmark_of_feature.fill(-1);
  scratch->distance_of_feature.fill(std::numeric_limits<std::int32_t>::max());
  const double ratio2 = input.ratio_max * input.ratio_max;
  const double focal_px = input.camera->focal_px();
  out->predicted = 0;
  for (std::size_t i = 0; i < input.map->landmarks.size(); ++i) {
    const Landmark& landmark = input.map->landmarks[i];
    ExpectedBlob blob{.pixel = {}, .within_px = radius_px};
    if (!takes_part(input, landmark) ||
        !should_be_seen(landmark, pose, *input.camera, &blob.pixel)) {
      continue;
    }
    ++out->predicted;
    blob.size_px = landmark.size_mu * focal_px / pose.to_camera(landmark.p_T).z();
    const NearestFeature best =
        with_avx2([&] { return best_candidate(*input.features, landmark, blob, scratch->grid); });
    if (best.feature < 0 || best.nearest2 > kDistance2Max || best.nearest2 > ratio2 * best.rival2) {
      continue;
    }
    const auto f = static_cast<std::size_t>(best.feature);
    if (best.nearest2 < scratch->distance_of_feature[f]) {
      scratch->distance_of_feature[f] = best.nearest2;
      scratch->landmark_of_feature[f] = static_cast<std::int32_t>(i);
    }
  }
  out->matches.clear();
  for (std::size_t f = 0; f < input.features->size(); ++f) {
    if (scratch->landmark_of_feature[f] >= 0) {
      add_match(input,
                static_cast<std::size_t>(scratch->landmark_of_feature[f]),
                static_cast<std::int32_t>(f),
                &out->matches);
    }
  }
}

bool should_be_seen(const Landmark& landmark,
                    const Pose& pose,
                    const CameraModel& camera,
                    Eigen::Vector2d* pixel) {
  const Eigen::Vector3d p_C = pose.to_camera(landmark.p_T);
  if (!(p_C.z() > 0.0) || landmark.observations < 1) {
    return false;
  }
  const Eigen::Vector3d to_camera_T = -(pose.R_CT.transpose() * p_C).normalized();
  if (landmark.normal_T.dot(to_camera_T) < kFacingCosineMin) {
    return false;
  }
  *pixel = project_px(camera, p_C);
  return pixel->x() >= 0.0 && pixel->y() >= 0.0 && pixel->x() < camera.width_px &&
         pixel->y() < camera.height_px;
}

Result<bool> solve_matched(const LocaliseInput& input,
                           const Pose* hint,
                           LocaliseScratch* scratch,
                           LocalisedFrame* out) {
  Result<bool> solved = solve_all(input, hint, scratch, out);
  if (solved && input.age == LandmarkAge::kAny &&
      drop_old_face_that_disagrees(*input.map, &out->matches)) {
    solved = solve_all(input, hint, scratch, out);
  }
  return solved;
}

PoseCovariance with_clutter(const LocalisedFrame& frame) {
  const double clutter = static_cast<double>(frame.matches.size()) /
                         static_cast<double>(std::max(1, frame.absolute.inliers));
  return std::max(1.0, clutter) * frame.absolute.covariance;
}

void take_matches(const LocaliseInput& input,
                  const LocalisedFrame& frame,
                  LocaliseScratch* scratch,
                  LocalisedFrame* out) {
  *out = frame;
  to_observations(input, out->matches, scratch);
  for (std::size_t i = 0; i < out->matches.size(); ++i) {
    scratch->inlier[i] = out->matches[i].inlier ? 1 : 0;
  }
}

void take_pose(const Pose& pose,
               const PoseCovariance& covariance,
               LocaliseScratch* scratch,
               LocalisedFrame* out) {
  out->absolute.pose = pose;
  out->absolute.covariance = covariance;
  out->absolute.inliers = mark_inliers(pose, scratch->observations.view(), flags(scratch));
  mark(*scratch, &out->matches);
}

Result<bool> localise_guided(const LocaliseInput& input,
                             const Pose& predicted,
                             double radius_px,
                             LocaliseScratch* scratch,
                             LocalisedFrame* out) {
  match_about(input, predicted, radius_px, scratch, out);
  const Result<bool> first = solve_matched(input, &predicted, scratch, out);
  return first ? polish(input, AbsolutePose(out->absolute), scratch, out) : first;
}

Result<bool> localise_matched(const LocaliseInput& input,
                              LocaliseScratch* scratch,
                              LocalisedFrame* out) {
  const Result<bool> first = solve_matched(input, nullptr, scratch, out);
  return first ? polish(input, AbsolutePose(out->absolute), scratch, out) : first;
}

Result<bool> localise_with_prior(const LocaliseInput& input,
                                 const PosePrediction& prior,
                                 LocaliseScratch* scratch,
                                 LocalisedFrame* out) {
  const AbsolutePose expected{.pose = prior.pose, .covariance = prior.covariance};
  match_about(input, prior.pose, reach_px(input, expected), scratch, out);
  to_observations(input, out->matches, scratch);
  const Result<AbsolutePose> pose = pose_with_prior(scratch->observations.view(),
                                                    prior.pose,
                                                    prior.covariance,
                                                    {.inliers_min = kInliersWithPrior},
                                                    flags(scratch));
  if (!pose) {
    return pose.error();
  }
  out->absolute = pose.value();
  mark(*scratch, &out->matches);
  return true;
}

}  // namespace polhode
