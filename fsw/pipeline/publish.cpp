#include "pipeline/publish.hpp"

#include <algorithm>

#include "bus/narrow.hpp"
#include "bus/publish.hpp"
#include "motion/published.hpp"
#include "pipeline/coast.hpp"
#include "pipeline/published_errors.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

std::uint16_t inliers(const LandmarkMatches& matches) {
  return bus::clipped(static_cast<std::size_t>(std::count_if(
      matches.begin(), matches.end(), [](const LandmarkMatch& m) { return m.inlier; })));
}

/// A pose in the published unit. Its error includes those of scale and camera.
/// @param covariance  of the pose in map units, the map's own error included.
/// @param q_last  quaternion published last; becomes this one.
void fill_pose_in_unit(const Pose& pose_mu,
                       PoseCovariance covariance,
                       const PublishedErrors& errors,
                       std::array<double, 4>* q_last,
                       MotionState* m) {
  const bus::LengthUnit& unit = errors.unit;
  const Pose pose = scaled(pose_mu, unit.metres_per_mu);
  covariance = scaled(covariance, unit.metres_per_mu);
  widen(errors.camera, pose.p_CT.norm(), &covariance);
  fill_pose(pose, covariance + by_scale(pose, unit.relative_sigma), q_last, m);
}

/// Shift of a match from the frame's time to its row's time.
Eigen::Vector2d row_shift_px(const CameraModel& camera, const LandmarkMatch& match) {
  if (camera.line_time_s == 0.0) {
    return Eigen::Vector2d::Zero();
  }
  return Eigen::Vector2d(match.u_px, match.v_px) - project_px(camera, match.normalised);
}

/// Lists matches with their landmarks' reprojections; without a pose, the frame's features.
void list_observations(const MapState& mapping,
                       const Features& features,
                       const CameraModel& camera,
                       Answer* answer) {
  answer->observations.clear();
  for (const LandmarkMatch& match : mapping.localised.matches) {
    const Landmark& landmark = mapping.map.landmarks[match.landmark.index()];
    if (!landmark.used) {
      continue;
    }
    Observation o{.landmark = landmark.number,
                  .u_px = match.u_px,
                  .v_px = match.v_px,
                  .normalised = {match.normalised.x(), match.normalised.y()},
                  .sigma_px = static_cast<float>(match.sigma_px),
                  .inlier = match.inlier};
    const Eigen::Vector3d p_C = mapping.localised.absolute.pose.to_camera(landmark.p_T);
    if (p_C.z() > 0.0) {
      const Eigen::Vector2d pixel = project_px(camera, p_C) + row_shift_px(camera, match);
      o.predicted_u_px = static_cast<float>(pixel.x());
      o.predicted_v_px = static_cast<float>(pixel.y());
    }
    (void)answer->observations.push_back(o);
  }
  for (const Feature& f : features) {
    if (mapping.pose_valid || answer->observations.full()) {
      break;
    }
    (void)answer->observations.push_back({.u_px = f.u_px,
                                          .v_px = f.v_px,
                                          .normalised = {f.normalised.x(), f.normalised.y()},
                                          .sigma_px = f.sigma_px});
  }
}

/// Errors of pose and rates include the map's drift, inconsistency, scale and a contradicted
/// camera. No rates where the rotations contradict the timestamps, and none of a predicted pose.
MotionState motion_state(std::int64_t timestamp_ns,
                         const StampDoubt& stamps,
                         const PublishedErrors& errors,
                         const Component::State& s) {
  const MapState& mapping = s.mapping;
  const bus::LengthUnit& unit = errors.unit;
  const LandmarkMatches& matches = mapping.localised.matches;
  MotionState m;
  m.frame = s.clock.frame;
  m.timestamp_ns = timestamp_ns;
  m.mode = s.mode.now;
  m.scale_known = s.scale.known;
  m.scale_number = unit.number;
  m.metres_per_mu = unit.metres_per_mu;
  m.target_frame = mapping.target_frame;
  m.features = bus::clipped(std::max(s.features.features.size(), matches.size()));
  m.matches = bus::clipped(matches.size());
  m.inliers = inliers(matches);
  m.landmarks = bus::clipped(static_cast<std::size_t>(mapping.map.landmark_count));
  m.keyframes = bus::clipped(static_cast<std::size_t>(mapping.map.keyframe_count));
  std::array<double, 4> q_last = s.bus.q_CT_last;
  if (mapping.pose_valid) {
    m.doubted = !mapping.inconsistency.isZero(0.0);
    const AbsolutePose& found = mapping.localised.absolute;
    const PoseCovariance in_all =
        found.covariance + covariance(mapping.drift) + mapping.inconsistency;
    fill_pose_in_unit(found.pose, in_all, errors, &q_last, &m);
    const Result<RateEstimate> rates =
        rates_now(s.motion, mapping.drift, s.configuration.parameters.motion);
    if (rates && !stamps.contradicted) {
      fill_rates(rates.value(), unit.metres_per_mu, unit.relative_sigma, &m);
    }
  } else if (m.mode == Mode::kCoasting) {
    if (const auto coasted = coasted_pose(timestamp_ns, s)) {
      fill_pose_in_unit(coasted->pose, coasted->covariance, errors, &q_last, &m);
    }
  }
  return m;
}

bus::TableStatus table_status(const Configuration& c) {
  return {.crc = c.table_crc,
          .loaded_crc = c.inactive.crc,
          .loaded_entries = c.inactive.entries,
          .loaded = c.inactive.begun,
          .memory_octets = c.memory_octets};
}

bus::View bus_view(FrameUse use,
                   const StampDoubt& stamps,
                   const PublishedErrors& errors,
                   const Component::State& s) {
  const Configuration& c = s.configuration;
  return {.use = use,
          .verdict = s.picture.verdict,
          .motion = &s.answer.output.motion,
          .counters = &s.counters,
          .estimate = &s.motion,
          .drift = &s.mapping.drift,
          .pose = &s.mapping.localised.absolute.pose,
          .stamps = stamps,
          .shape = &s.shape,
          .scale = &s.scale,
          .camera = {.stated = &c.camera, .found = &s.camera.found, .error = errors.camera},
          .unit = errors.unit,
          .has_map = s.mapping.map.landmark_count > 0,
          .held = s.mode.held,
          .table = table_status(c),
          .motion_options = &c.parameters.motion,
          .options = &c.parameters.bus,
          .version = kVersion};
}

}  // namespace

void publish(FrameUse use, std::int64_t timestamp_ns, Component::State* s) {
  change_unit(lengths_unit(*s), &s->bus.scale);
  const PublishedErrors errors = published_errors(*s);
  const StampDoubt stamps =
      s->mapping.pose_valid ? doubt_of_stamps(s->motion.recent.view()) : StampDoubt{};
  StepOutput& output = s->answer.output;
  output.use = use;
  output.verdict = s->picture.verdict;
  output.motion = motion_state(timestamp_ns, stamps, errors, *s);
  if (output.motion.pose_valid) {
    s->bus.q_CT_last = output.motion.q_CT;
  }
  list_observations(s->mapping, s->features.features, s->configuration.camera, &s->answer);
  output.observations = s->answer.observations.view();
  const bus::View view = bus_view(use, stamps, errors, *s);
  bus::publish(view, &s->bus);
  s->shape.is_new = s->shape.is_new && !view.has_map;  // else it has been sent
  output.packets = s->bus.stream.view();
  output.jobs = hand_out(&s->jobs);
}

}  // namespace polhode
