// Synthetic tracks as the start of a map takes them, and how right its answer is.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/so3.hpp"
#include "initialisation/initialise.hpp"
#include "synthetic/tracks.hpp"

namespace polhode::synthetic {

/// The first kInitialFrames frames of each of the first kInitialTracks tracks.
inline std::vector<InitialTrack> to_start_tracks(const std::vector<Track>& tracks,
                                                 double sigma_normalised) {
  std::vector<InitialTrack> out;
  for (const Track& track : tracks) {
    InitialTrack start;
    for (const Observation& o : track.observations) {
      (void)start.observations.push_back(
          {.frame = o.frame, .normalised = o.normalised, .sigma_normalised = sigma_normalised});
    }
    out.push_back(start);
  }
  return out;
}

struct InitialErrors {
  double depth = 1e300;  ///< depth profile in the first posed frame: RMS error over RMS depth,
                         ///< after scaling by the sides
  double rotation =
      1e300;  ///< error of the turn from the first to the last posed frame over that turn
  [[nodiscard]] bool right() const { return depth < 0.25 && rotation < 0.25; }
};

/// Against the truth; the outcome has to have poses.
inline InitialErrors compare_start(const InitialOutcome& out,
                                   const std::vector<Track>& tracks,
                                   const Motion& motion) {
  InitialErrors errors;
  std::size_t first = out.frames.size();
  std::size_t last = 0;
  for (std::size_t f = 0; f < out.frames.size(); ++f) {
    if (out.frames[f].valid) {
      first = std::min(first, f);
      last = f;
    }
  }
  if (first >= last) {
    return errors;
  }
  std::vector<Eigen::Vector3d> estimated;
  std::vector<Eigen::Vector3d> truth;
  Eigen::Vector3d mean_e = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_t = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    if (out.points[i].valid && !tracks[i].outlier) {
      estimated.push_back(out.frames[first].pose.R_CT * out.points[i].p_T);
      truth.push_back(motion.poses[first].R_CT * tracks[i].p_B);
      mean_e += estimated.back();
      mean_t += truth.back();
    }
  }
  if (estimated.size() < 8) {
    return errors;
  }
  mean_e /= static_cast<double>(estimated.size());
  mean_t /= static_cast<double>(truth.size());
  double sides_te = 0.0;
  double sides_ee = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sides_te += (truth[i] - mean_t).head<2>().dot((estimated[i] - mean_e).head<2>());
    sides_ee += (estimated[i] - mean_e).head<2>().squaredNorm();
  }
  const double scale = sides_te / sides_ee;
  double wrong = 0.0;
  double deep = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double depth = truth[i].z() - mean_t.z();
    wrong += std::pow(scale * (estimated[i].z() - mean_e.z()) - depth, 2);
    deep += depth * depth;
  }
  errors.depth = std::sqrt(wrong / deep);
  const Eigen::Matrix3d turn_e =
      out.frames[last].pose.R_CT * out.frames[first].pose.R_CT.transpose();
  const Eigen::Matrix3d turn_t = motion.poses[last].R_CT * motion.poses[first].R_CT.transpose();
  errors.rotation = rotation_angle_rad(turn_e, turn_t) / so3_log(turn_t).norm();
  return errors;
}

}  // namespace polhode::synthetic
