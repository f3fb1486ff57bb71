#include "synthetic/tracks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace polhode::synthetic {
namespace {

Eigen::Vector2d in_disc(double radius, Rng* rng) {
  const double r = radius * std::sqrt(rng->uniform());
  const double angle = 2.0 * std::numbers::pi * rng->uniform();
  return {r * std::cos(angle), r * std::sin(angle)};
}

bool faces_camera(const SurfacePoint& point, const Pose& pose, double cosine_min) {
  const Eigen::Vector3d p_C = pose.to_camera(point.p_B);
  return -p_C.normalized().dot(pose.R_CT * point.normal_B) > cosine_min;
}

Track ideal_track(const SurfacePoint& point, const Motion& motion, double cosine_min) {
  Track track;
  track.p_B = point.p_B;
  for (std::size_t f = 0; f < motion.poses.size(); ++f) {
    if (faces_camera(point, motion.poses[f], cosine_min)) {
      const Eigen::Vector3d p_C = motion.poses[f].to_camera(point.p_B);
      track.observations.push_back({static_cast<int>(f), {p_C.x() / p_C.z(), p_C.y() / p_C.z()}});
    }
  }
  return track;
}

/// A glint or a shadow edge: it keeps near the body and moves steadily, by some pixels a frame.
void slide(double focal_px, Rng* rng, Track* track) {
  track->outlier = true;
  const Eigen::Vector2d step =
      in_disc(1.0, rng).normalized() * (2.0 + 6.0 * rng->uniform()) / focal_px;
  for (Observation& o : track->observations) {
    o.normalised += step * (o.frame - track->observations.front().frame);
  }
}

void spoil(const Motion& motion, const Imaging& imaging, double size, Rng* rng, Track* track) {
  for (Observation& o : track->observations) {
    if (rng->uniform() < imaging.wrong_matches) {
      const Pose& pose = motion.poses[static_cast<std::size_t>(o.frame)];
      o.normalised = pose.p_CT.head<2>() / pose.p_CT.z() + in_disc(size / pose.p_CT.z(), rng);
    }
    o.normalised.x() += imaging.noise_px / imaging.focal_px * rng->normal();
    o.normalised.y() += imaging.noise_px / imaging.focal_px * rng->normal();
  }
  std::erase_if(track->observations,
                [&](const Observation&) { return rng->uniform() < imaging.lost; });
}

}  // namespace

std::vector<Track> track_points(const Body& body,
                                const Motion& motion,
                                const Imaging& imaging,
                                Rng* rng) {
  std::vector<Track> tracks;
  const double size = radius_m(body);
  for (const SurfacePoint& point : body) {
    Track track = ideal_track(point, motion, imaging.grazing_cosine_min);
    const std::size_t needed = imaging.all_frames_only ? motion.poses.size() : 2;
    if (track.observations.size() < needed) {
      continue;
    }
    if (rng->uniform() < imaging.outlier_tracks) {
      slide(imaging.focal_px, rng, &track);
    }
    spoil(motion, imaging, size, rng, &track);
    if (track.observations.size() >= 2) {
      tracks.push_back(track);
    }
    if (imaging.tracks_max > 0 && static_cast<int>(tracks.size()) == imaging.tracks_max) {
      break;
    }
  }
  return tracks;
}

std::vector<Track> random_tracks(
    int tracks, int frames, double radius_px, double focal_px, Rng* rng) {
  std::vector<Track> out(static_cast<std::size_t>(tracks));
  for (Track& track : out) {
    track.outlier = true;
    for (int f = 0; f < frames; ++f) {
      track.observations.push_back({f, in_disc(radius_px / focal_px, rng)});
    }
  }
  return out;
}

}  // namespace polhode::synthetic
