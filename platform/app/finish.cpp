#include "app/finish.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "app/model_json.hpp"
#include "app/motion_csv.hpp"
#include "app/ply.hpp"
#include "app/shape_json.hpp"
#include "app/smoothed.hpp"
#include "app/trajectory.hpp"
#include "camera/replay/file_camera.hpp"
#include "pipeline/scale_now.hpp"
#include "pipeline/smooth.hpp"
#include "pipeline/state.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

Pose causal_pose(const MotionState& m, double metres_per_mu) {
  const Eigen::Quaterniond q(m.q_CT[0], m.q_CT[1], m.q_CT[2], m.q_CT[3]);
  return {.R_CT = q.toRotationMatrix(),
          .p_CT = Eigen::Vector3d(m.p_CT[0], m.p_CT[1], m.p_CT[2]) /
                  (m.scale_known ? metres_per_mu : 1.0)};
}

/// Every frame's pose from the map at rest. Frames that had none at their time are looked at again.
std::vector<SmoothedPose> smooth_frames(Component& component,
                                        const Sequence& sequence,
                                        const ReplayLog& log) {
  Component::State& state = component.state();
  bring_to_rest(&state);
  MapAtRest at_rest(&state);
  FileCamera camera(sequence);
  std::vector<SmoothedPose> poses;
  for (std::size_t i = 0; i < log.published.size(); ++i) {
    const MotionState& m = log.published[i];
    const Pose hint = causal_pose(m, state.scale.metres_per_mu);
    SmoothedPose pose = at_rest.from_log(m.frame, hint, log.observations.of_frame(i));
    Frame frame;
    if (!pose.valid && state.map.keyframe_count > 0) {
      camera.seek(i);
      if (camera.next(frame) && frame.readable) {
        pose = at_rest.from_image(frame);
      }
    }
    poses.push_back(pose);
  }
  return poses;
}

/// A frame that carries the scale may have found its pose only now.
void measure_scale_late(const ReplayLog& log,
                        const std::vector<SmoothedPose>& poses,
                        Component::State* state) {
  if (state->parameters.scale.source == ScaleSource::kNone || state->scale.known) {
    return;
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].valid &&
        log.published[i].timestamp_ns == state->parameters.scale.frame_timestamp_ns) {
      std::vector<Eigen::Vector3d> seen;
      for (const Landmark& landmark : state->map.landmarks) {
        Eigen::Vector2d pixel;
        if (landmark.used &&
            should_be_seen(landmark, poses[i].absolute.pose, state->camera, &pixel)) {
          seen.push_back(landmark.p_T);
        }
      }
      (void)measure_scale_in(poses[i].absolute.pose, seen, state);
    }
  }
}

struct FoundShape {
  std::unique_ptr<ShapeWork> work = std::make_unique<ShapeWork>();
  std::optional<Shape> shape;
  std::string reason;
  BodyFrame body;
};

/// Landmarks in metres once the scale is known.
std::vector<Eigen::Vector3d> landmarks_T(const Component::State& state) {
  std::vector<Eigen::Vector3d> points = confirmed_landmarks(state);
  for (Eigen::Vector3d& point : points) {
    point *= state.scale.metres_per_mu;
  }
  return points;
}

FoundShape find_shape(const Component::State& state, const std::vector<Eigen::Vector3d>& points_T) {
  FoundShape found;
  const Result<Shape> shape =
      estimate_shape(points_T, state.parameters.shape, state.parameters.seed, nullptr, *found.work);
  if (!shape) {
    found.reason =
        points_T.empty() ? "there is no map" : "too few landmarks, or none on a common surface";
    return found;
  }
  found.shape = shape.value();
  found.body = {.R_TB = shape.value().frame.R_TB, .centroid_T = shape.value().centroid_T};
  return found;
}

std::vector<Eigen::Vector3d> in_body(const BodyFrame& body,
                                     std::span<const Eigen::Vector3d> points_T) {
  std::vector<Eigen::Vector3d> points_B;
  for (const Eigen::Vector3d& point : points_T) {
    points_B.push_back(body.R_TB.transpose() * (point - body.centroid_T));
  }
  return points_B;
}

void write_clouds(const FoundShape& found,
                  const std::vector<Eigen::Vector3d>& points_T,
                  const fs::path& folder) {
  write_ply(folder / "cloud_raw.ply",
            {.points = in_body(found.body, points_T),
             .normals = {},
             .rgb = {},
             .comment = "landmarks, body frame"});
  if (!found.shape) {  // an empty cloud, so that readers find every file of the table
    write_ply(folder / "cloud.ply",
              {.points = {}, .normals = {}, .rgb = {}, .comment = "nothing found"});
    return;
  }
  const Cloud& cloud = found.work->cloud;
  const std::vector<Eigen::Vector3d> points_B = in_body(found.body, cloud.points_T.view());
  std::vector<std::array<std::uint8_t, 3>> rgb(points_B.size(), {200, 200, 200});
  std::fill(rgb.begin() + static_cast<std::ptrdiff_t>(cloud.measured),
            rgb.end(),
            std::array<std::uint8_t, 3>{240, 140, 40});
  write_ply(folder / "cloud.ply",
            {.points = points_B,
             .normals = {},
             .rgb = rgb,
             .comment = "denoised, body frame; orange: added"});
}

void write_smoothed(const std::vector<MotionState>& smoothed,
                    const ReplayLog& log,
                    const fs::path& folder) {
  OutputFile table(folder / "motion_smoothed.csv");
  table.write(motion_csv_header());
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    table.write(motion_csv_row(
        {.frame = i, .timestamp_ns = log.published[i].timestamp_ns, .used = true}, smoothed[i]));
  }
  table.close();
  write_trajectory(folder / "trajectory.tum", smoothed);
}

}  // namespace

void finish_replay(Component& component,
                   const Sequence& sequence,
                   const ReplayLog& log,
                   const fs::path& folder) {
  const std::vector<SmoothedPose> poses = smooth_frames(component, sequence, log);
  Component::State& state = component.state();
  measure_scale_late(log, poses, &state);
  const std::vector<Eigen::Vector3d> points_T = landmarks_T(state);
  const FoundShape found = find_shape(state, points_T);
  write_clouds(found, points_T, folder);
  write_shape_json(folder / "shape.json",
                   {.shape = found.shape ? &*found.shape : nullptr,
                    .reason = found.reason,
                    .scale_source = state.parameters.scale.source,
                    .scale_known = state.scale.known,
                    .metres_per_mu = state.scale.metres_per_mu,
                    .sigma_metres_per_mu = state.scale.relative_sigma * state.scale.metres_per_mu});
  const std::vector<PoseSample> samples = samples_in_body(
      poses, log.published, found.body, state.scale.metres_per_mu, log.servicer);
  const double radius = found.shape ? 0.5 * found.shape->dimensions.maxCoeff()
                                    : state.map.radius_mu * state.scale.metres_per_mu;
  const RigidModel model = model_of(samples, radius, state);
  write_smoothed(
      smoothed_motion(poses, samples, log.published, model, log.servicer, state), log, folder);
  write_model_json(folder / "motion_model.json",
                   {.samples = samples,
                    .model = model,
                    .options = state.parameters.motion,
                    .body_radius = radius,
                    .scale_known = state.scale.known,
                    .R_CI = samples.empty()
                                ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                : Eigen::Matrix3d(
                                      log.servicer.R_IC(samples.back().timestamp_ns).transpose())});
}

}  // namespace polhode::platform
