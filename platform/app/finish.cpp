#include "app/finish.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "app/cloud_details.hpp"
#include "app/model_json.hpp"
#include "app/motion_csv.hpp"
#include "app/ply.hpp"
#include "app/shape_json.hpp"
#include "app/smoothed.hpp"
#include "app/trajectory.hpp"
#include "camera/replay/file_camera.hpp"
#include "pipeline/ground_view.hpp"
#include "pipeline/smooth.hpp"
#include "print_stderr.hpp"
#include "shape/hull.hpp"
#include "shape/scale_state.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

Pose causal_pose(const MotionState& m) {
  const Eigen::Quaterniond q(m.q_CT[0], m.q_CT[1], m.q_CT[2], m.q_CT[3]);
  return {.R_CT = q.toRotationMatrix(),
          .p_CT = Eigen::Vector3d(m.p_CT[0], m.p_CT[1], m.p_CT[2]) / m.metres_per_mu};
}

/// Every frame's pose from the converged map. Frames without a pose in the run are tried again.
/// A pose inconsistent with the motion is left out: its image is of another time, or of the first
/// moment after a contact. So are all poses of a map that was not confirmed.
std::vector<SmoothedPose> smooth_frames(Component& component,
                                        const Sequence& sequence,
                                        const ReplayLog& log) {
  MapAtRest converged(&component);
  const GroundView view = view_of(component);
  FileCamera camera(sequence);
  const bool confirmed = is_confirmed(log.published);
  std::vector<SmoothedPose> poses;
  for (std::size_t i = 0; i < log.published.size(); ++i) {
    const MotionState& m = log.published[i];
    if (m.doubted || !confirmed) {
      poses.push_back({});
      continue;
    }
    const Pose hint = causal_pose(m);
    SmoothedPose pose = converged.from_log(m.frame, hint, log.observations.of_frame(i));
    Frame frame;
    if (!pose.valid && log.uses[i] == FrameUse::kUsed && view.map.keyframe_count > 0) {
      camera.seek(i);
      if (camera.next(frame) && frame.readable) {
        pose = converged.from_image(frame);
      }
    }
    poses.push_back(pose);
  }
  return poses;
}

/// The frame that carries the scale may have found its pose only now, and has its best one now:
/// that of its keyframe, or the one by its image.
void measure_scale_late(const Sequence& sequence, const ReplayLog& log, Component* component) {
  const GroundView view = view_of(*component);
  const ScaleOptions& options = view.parameters.scale;
  if (!names_frame(options) || view.map.keyframe_count == 0 || read_scale_in_keyframe(component)) {
    return;
  }
  MapAtRest converged(component);
  FileCamera camera(sequence);
  for (std::size_t i = 0; i < log.published.size(); ++i) {
    Frame frame;
    if (log.uses[i] == FrameUse::kUsed &&
        log.published[i].timestamp_ns == options.frame_timestamp_ns) {
      camera.seek(i);
      if (camera.next(frame) && frame.readable && converged.from_image(frame).valid) {
        (void)read_scale_in_image(component);
      }
    }
  }
}

struct FoundShape {
  std::unique_ptr<ShapeWork> work = std::make_unique<ShapeWork>();
  std::optional<Shape> shape;
  std::optional<Hull> surface;
  std::string reason;
  BodyFrame body;
};

/// Landmarks in metres once the scale is known.
ConfirmedLandmarks landmarks_of(const GroundView& view) {
  ConfirmedLandmarks landmarks = confirmed_landmarks(view.map, view.camera);
  for (std::size_t i = 0; i < landmarks.points_T.size(); ++i) {
    landmarks.points_T[i] *= view.scale.metres_per_mu;
    landmarks.sigmas[i] *= view.scale.metres_per_mu;
  }
  return landmarks;
}

/// The scale may come from a diameter or an edge of the shape.
void measure_scale_by_shape(Component* component) {
  const GroundView view = view_of(*component);
  const ScaleOptions& options = view.parameters.scale;
  if (options.known_diameter_m == 0.0 && options.known_edge_m == 0.0) {
    return;
  }
  const auto work = std::make_unique<ShapeWork>();
  const Result<Shape> shape = estimate_shape(confirmed_landmarks(view.map, view.camera).points_T,
                                             view.parameters.shape,
                                             view.parameters.seed,
                                             nullptr,
                                             *work);
  if (shape) {
    (void)read_scale_in_shape(shape.value(), component);
  }
}

/// A length, range, diameter or edge was given, and lengths are in map units all the same.
void print_scale_that_was_not_read(const GroundView& view) {
  const ScaleOptions& o = view.parameters.scale;
  const auto print_stderr = [](const char* key, const char* why) {
    platform::print_stderr("polhode: {}: not read: {}; lengths stay in map units\n", key, why);
  };
  if (view.scale.known || view.scale.contradiction) {
    return;
  }
  if (o.known_length_m != 0.0) {
    print_stderr(
        "scale.known_length_m",
        "its frame has no pose, its points are not on the target, or where they lie is in doubt");
  }
  if (o.range_m != 0.0) {
    print_stderr("scale.range_m",
                 "its frame has no pose, or the boresight does not meet the target");
  }
  if (o.known_diameter_m != 0.0) {
    print_stderr("scale.known_diameter_m", "no round body was found");
  }
  if (o.known_edge_m != 0.0) {
    print_stderr("scale.known_edge_m", "no flat side with such an edge was found");
  }
}

FoundShape find_shape(const GroundView& view, const std::vector<Eigen::Vector3d>& points_T) {
  FoundShape found;
  const Result<Shape> shape =
      estimate_shape(points_T, view.parameters.shape, view.parameters.seed, nullptr, *found.work);
  if (!shape) {
    found.reason =
        points_T.empty() ? "there is no map" : "too few landmarks, or none on a common surface";
    return found;
  }
  found.shape = shape.value();
  found.body = {.R_TB = shape.value().frame.R_TB, .centroid_T = shape.value().centroid_T};
  const auto hull_work = std::make_unique<HullWork>();
  // Details below the cloud's resolution are left out of its surface.
  const double tolerance = std::max(0.5 * shape.value().spacing, shape.value().thickness);
  const Result<Hull> hull = convex_hull(found.work->cloud.points_T.view(), tolerance, *hull_work);
  if (hull) {
    found.surface = hull.value();
  }
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

/// The convex hull; without faces where nothing encloses a volume.
void write_surface(const FoundShape& found, const fs::path& folder) {
  std::vector<Eigen::Vector3d> vertices_B;
  std::vector<std::array<std::uint32_t, 3>> faces;
  if (found.surface) {
    vertices_B = in_body(found.body, found.surface->vertices_T.view());
    for (const auto& [a, b, c] : found.surface->faces) {
      faces.push_back({a, b, c});
    }
  }
  write_ply(folder / "surface.ply",
            {.points = vertices_B,
             .normals = {},
             .rgb = {},
             .faces = faces,
             .comment = found.surface ? "convex hull of cloud.ply, body frame" : "nothing found"});
}

void write_clouds(const FoundShape& found,
                  const ConfirmedLandmarks& landmarks,
                  const ShapeOptions& options,
                  const fs::path& folder) {
  write_ply(folder / "cloud_raw.ply",
            {.points = in_body(found.body, landmarks.points_T),
             .normals = {},
             .rgb = {},
             .landmark = landmarks.numbers,
             .comment = "landmarks, body frame; landmark: number as in observations.csv"});
  write_surface(found, folder);
  if (!found.shape) {  // an empty cloud, so that readers find every file of the table
    write_ply(folder / "cloud.ply",
              {.points = {}, .normals = {}, .rgb = {}, .comment = "nothing found"});
    return;
  }
  const Cloud& cloud = found.work->cloud;
  const std::vector<Eigen::Vector3d> points_B = in_body(found.body, cloud.points_T.view());
  const CloudDetails details = details_of(
      *found.shape, *found.work, landmarks, options.voxel_spacings * found.shape->spacing);
  const std::vector<Eigen::Vector3d> normals_B =
      in_body({.R_TB = found.body.R_TB}, details.normals_T);
  std::vector<std::array<std::uint8_t, 3>> rgb(points_B.size(), {200, 200, 200});
  std::fill(rgb.begin() + static_cast<std::ptrdiff_t>(cloud.measured),
            rgb.end(),
            std::array<std::uint8_t, 3>{240, 140, 40});
  std::vector<std::uint8_t> added(points_B.size(), 0);
  std::fill(added.begin() + static_cast<std::ptrdiff_t>(cloud.measured), added.end(), 1);
  write_ply(folder / "cloud.ply",
            {.points = points_B,
             .normals = normals_B,
             .rgb = rgb,
             .added = added,
             .sigma = details.sigmas,
             .views = details.views,
             .comment = "denoised, body frame; orange, added = 1: by completion, not measured; "
                        "sigma: worst axis, in the map; views: keyframes that see it"});
}

void write_smoothed(const std::vector<MotionState>& smoothed,
                    const ReplayLog& log,
                    const fs::path& folder) {
  OutputFile table(folder / "motion_smoothed.csv");
  table.write(motion_csv_header());
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    table.write(motion_csv_row({.frame = i,
                                .timestamp_ns = log.published[i].timestamp_ns,
                                .used = log.uses[i] == FrameUse::kUsed},
                               smoothed[i]));
  }
  table.close();
  write_trajectory(folder / "trajectory.tum", smoothed);
  write_last_trajectory(folder / "smoothed.tum", smoothed);
  write_last_trajectory(folder / "causal.tum", log.published);
}

}  // namespace

CameraReport finish_replay(Component& component,
                           const Sequence& sequence,
                           const ReplayLog& log,
                           const fs::path& folder) {
  bring_to_rest(&component);
  const CameraFit camera = test_camera_at_rest(&component);
  const std::vector<SmoothedPose> poses = smooth_frames(component, sequence, log);
  measure_scale_late(sequence, log, &component);
  measure_scale_by_shape(&component);
  const GroundView view = view_of(component);
  print_scale_that_was_not_read(view);
  const ConfirmedLandmarks landmarks = landmarks_of(view);
  const FoundShape found = find_shape(view, landmarks.points_T);
  write_clouds(found, landmarks, view.parameters.shape, folder);
  ScaleState scale = view.scale;
  scale.relative_sigma = std::hypot(scale.relative_sigma, error_by(view.camera_found, 0.0).along);
  write_shape_json(folder / "shape.json",
                   {.shape = found.shape ? &*found.shape : nullptr,
                    .reason = found.reason,
                    .surface = found.surface ? &*found.surface : nullptr,
                    .scale_options = view.parameters.scale,
                    .scale = scale});
  const std::vector<PoseSample> samples =
      samples_in_body(poses, log.published, found.body, view.scale.metres_per_mu, log.servicer);
  const double radius = found.shape ? 0.5 * found.shape->dimensions.maxCoeff()
                                    : view.map.radius_mu * view.scale.metres_per_mu;
  const std::optional<RigidModel> of_map =
      motion_is_of_map(component) ? model_of_map(samples, found.body, view) : std::nullopt;
  const RigidModel model = of_map ? *of_map : model_of(samples, radius, view);
  write_smoothed(
      smoothed_motion({poses, samples, log.published}, model, log.servicer, view), log, folder);
  write_model_json(
      folder / "motion_model.json",
      {.samples = samples,
       .model = model,
       .options = view.parameters.motion,
       .body_radius = radius,
       .scale_known = view.scale.known,
       .scale_sigma = scale.relative_sigma,
       .camera = view.camera_found,
       .R_CI = samples.empty()
                   ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                   : Eigen::Matrix3d(log.servicer.R_IC(samples.back().timestamp_ns).transpose())});
  return {.found = view.camera_found, .fit = camera};
}

}  // namespace polhode::platform
