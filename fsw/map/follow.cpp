#include "map/follow.hpp"

#include "base/median.hpp"

namespace polhode {
namespace {

bool project(const Map& map,
             LandmarkId id,
             const Pose& pose,
             const CameraModel& camera,
             Eigen::Vector2d* pixel) {
  const Landmark& landmark = map.landmarks[id.index()];
  const Eigen::Vector3d p_C = pose.to_camera(landmark.p_T);
  if (!landmark.used || !(p_C.z() > 0.0)) {
    return false;
  }
  *pixel = project_px(camera, p_C);
  return true;
}

}  // namespace

double predicted_motion_px(const FlowReference& reference,
                           const Pose& predicted,
                           const Map& map,
                           const CameraModel& camera) {
  constexpr double kOutOfReach_px = 1e6;  // beyond any image's width
  FixedVector<double, limits::kPoseMatches> motions;
  for (const LandmarkMatch& point : reference.points) {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
    if (project(map, point.landmark, reference.pose, camera, &from) &&
        project(map, point.landmark, predicted, camera, &to)) {
      (void)motions.push_back((to - from).norm());
    }
  }
  if (motions.size() < 4) {
    return kOutOfReach_px;
  }
  return median(motions.view());
}

Result<bool> localise_by_flow(const LocaliseInput& input,
                              const FlowPair& flow,
                              const Pose& predicted,
                              LocaliseScratch* scratch,
                              LocalisedFrame* out) {
  const FlowReference& reference = *flow.reference;
  FixedVector<FlowPoint, limits::kPoseMatches> from;
  FixedVector<FlowPoint, limits::kPoseMatches> to;
  out->matches.clear();
  for (const LandmarkMatch& point : reference.points) {
    Eigen::Vector2d before;
    Eigen::Vector2d now;
    if (!project(*input.map, point.landmark, reference.pose, *input.camera, &before) ||
        !project(*input.map, point.landmark, predicted, *input.camera, &now)) {
      continue;
    }
    // The measurement error in the reference image stays with the patch.
    const Eigen::Vector2d shift = now - before;
    (void)from.push_back({.u_px = point.u_px, .v_px = point.v_px});
    (void)to.push_back({.u_px = point.u_px + static_cast<float>(shift.x()),
                        .v_px = point.v_px + static_cast<float>(shift.y())});
    (void)out->matches.push_back(point);
  }
  out->predicted = static_cast<int>(out->matches.size());
  follow_points(reference.pyramid, *flow.pyramid, from.view(), *flow.options, to.view());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < to.size(); ++i) {
    if (!to[i].followed) {
      continue;
    }
    LandmarkMatch match = out->matches[i];
    match.feature = -1;
    match.u_px = to[i].u_px;
    match.v_px = to[i].v_px;
    match.normalised =
        at_frame_time(*input.camera,
                      input.image_motion,
                      {static_cast<double>(match.u_px), static_cast<double>(match.v_px)});
    out->matches[kept++] = match;
  }
  out->matches.resize(kept);
  return solve_matched(input, &predicted, scratch, out);
}

}  // namespace polhode
