#include "pipeline/publish.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bus/narrow.hpp"
#include "pipeline/jobs.hpp"
#include "pipeline/telemetry.hpp"

namespace polhode {
namespace {

std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Rows of the upper triangle, one after the other.
template <std::size_t kCount, typename Matrix>
std::array<double, kCount> upper_triangle(const Matrix& m) {
  std::array<double, kCount> out{};
  std::size_t i = 0;
  for (Eigen::Index row = 0; row < m.rows(); ++row) {
    for (Eigen::Index column = row; column < m.cols(); ++column) {
      out[i++] = m(row, column);
    }
  }
  return out;
}

std::uint16_t inliers(const LandmarkMatches& matches) {
  return bus::clipped(static_cast<std::size_t>(std::count_if(
      matches.begin(), matches.end(), [](const LandmarkMatch& m) { return m.inlier; })));
}

/// Of the two quaternions of one rotation the one nearer to the last published.
std::array<double, 4> continuous_quaternion(const Eigen::Matrix3d& R_CT,
                                            std::array<double, 4>* last) {
  Eigen::Quaterniond q(R_CT);
  q.normalize();
  const double dot =
      q.w() * (*last)[0] + q.x() * (*last)[1] + q.y() * (*last)[2] + q.z() * (*last)[3];
  if (dot < 0.0) {
    q.coeffs() *= -1.0;
  }
  *last = {q.w(), q.x(), q.y(), q.z()};
  return *last;
}

void fill_rates(double unit, const Component::State& s, MotionState* m) {
  Result<RateEstimate> rates = rates_now(s.motion, s.drift, s.parameters.motion);
  if (!rates) {
    return;
  }
  RateEstimate& found = rates.value();
  found.v_C *= unit;
  found.covariance_v_C = unit * unit * found.covariance_v_C + by_scale(found.v_C, length_sigma(s));
  publish(found, *m);
  m->cov_w = upper_triangle<6>(found.covariance_w_T);
  m->cov_v = upper_triangle<6>(found.covariance_v_C);
}

void list_observations(Component::State* s) {
  s->observations.clear();
  for (const LandmarkMatch& match : s->localised.matches) {
    const Landmark& landmark = s->map.landmarks[match.landmark.index()];
    if (!landmark.used) {
      continue;
    }
    Observation o{.landmark = landmark.number,
                  .u_px = match.u_px,
                  .v_px = match.v_px,
                  .sigma_px = static_cast<float>(match.sigma_px),
                  .inlier = match.inlier};
    const Eigen::Vector3d p_C = s->localised.absolute.pose.to_camera(landmark.p_T);
    if (p_C.z() > 0.0) {
      const Eigen::Vector2d pixel = project_px(s->camera, p_C);
      o.predicted_u_px = static_cast<float>(pixel.x());
      o.predicted_v_px = static_cast<float>(pixel.y());
    }
    (void)s->observations.push_back(o);
  }
  for (const Feature& f : s->features) {
    if (s->pose_valid || s->observations.full()) {
      break;
    }
    (void)s->observations.push_back({.u_px = f.u_px, .v_px = f.v_px, .sigma_px = f.sigma_px});
  }
}

}  // namespace

void fill_pose(const Pose& pose,
               const PoseCovariance& covariance,
               std::array<double, 4>* q_last,
               MotionState* m) {
  m->pose_valid = true;
  m->q_CT = continuous_quaternion(pose.R_CT, q_last);
  m->p_CT = to_array(pose.p_CT);
  m->sigma_att_rad = worst_sigma(covariance.topLeftCorner<3, 3>());
  m->sigma_pos = worst_sigma(covariance.bottomRightCorner<3, 3>());
  m->cov_pose = upper_triangle<21>(covariance);
}

Pose scaled(const Pose& pose, double unit) { return {.R_CT = pose.R_CT, .p_CT = unit * pose.p_CT}; }

PoseCovariance scaled(const PoseCovariance& covariance, double unit) {
  Eigen::Matrix<double, 6, 1> units;
  units << 1.0, 1.0, 1.0, unit, unit, unit;
  return units.asDiagonal() * covariance * units.asDiagonal();
}

Eigen::Matrix3d by_scale(const Eigen::Vector3d& length, double scale_sigma) {
  return scale_sigma * scale_sigma * length * length.transpose();
}

PoseCovariance by_scale(const Pose& pose, double scale_sigma) {
  PoseCovariance added = PoseCovariance::Zero();
  added.bottomRightCorner<3, 3>() = by_scale(pose.p_CT, scale_sigma);
  return added;
}

void publish(FrameUse use, std::int64_t timestamp_ns, Component::State* s) {
  if (!s->pose_valid) {
    s->localised.matches.clear();
  }
  MotionState m;
  m.frame = s->frame;
  m.timestamp_ns = timestamp_ns;
  m.mode = s->mode;
  m.scale_known = s->scale.known;
  m.target_frame = s->target_frame;
  m.features = bus::clipped(std::max(s->features.size(), s->localised.matches.size()));
  m.matches = bus::clipped(s->localised.matches.size());
  m.inliers = inliers(s->localised.matches);
  m.landmarks = bus::clipped(static_cast<std::size_t>(s->map.landmark_count));
  m.keyframes = bus::clipped(static_cast<std::size_t>(s->map.keyframe_count));
  if (s->pose_valid) {
    const AbsolutePose& absolute = s->localised.absolute;
    const double unit = s->scale.metres_per_mu;
    const Pose pose = scaled(absolute.pose, unit);
    fill_pose(
        pose,
        scaled(absolute.covariance + covariance(s->drift), unit) + by_scale(pose, length_sigma(*s)),
        &s->q_CT_last,
        &m);
    fill_rates(unit, *s, &m);
  }
  list_observations(s);
  s->output.use = use;
  s->output.verdict = s->verdict;
  s->output.motion = m;
  s->output.observations = s->observations.view();
  send_telemetry(use, m, s);
  s->output.jobs = jobs_for_caller(s);
}

}  // namespace polhode
