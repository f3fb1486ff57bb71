// Point tracks of a moving body as a camera would deliver them, with what is true of each.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/rng.hpp"
#include "synthetic/bodies.hpp"
#include "synthetic/motions.hpp"

namespace polhode::synthetic {

struct Observation {
  int frame = 0;
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();
};

struct Track {
  Eigen::Vector3d p_B = Eigen::Vector3d::Zero();
  bool outlier = false;  ///< its images do not belong to one point
  std::vector<Observation> observations;
};

struct Imaging {
  double focal_px = 2667.0;
  double noise_px = 0.5;  ///< of each coordinate, 1-sigma, white
  double outlier_tracks =
      0.0;                     ///< part of the tracks that slides over the body at random, steadily
  double wrong_matches = 0.0;  ///< part of the single images that lies anywhere on the body
  double lost = 0.0;           ///< part of the single images that is missing
  double grazing_cosine_min = 0.1;  ///< a surface is seen up to 84 deg from its normal
  bool all_frames_only = false;     ///< only points that every frame sees
  int tracks_max = 0;               ///< 0: no limit
};

/// Tracks of two images or more, in the order of the body's points.
std::vector<Track> track_points(const Body& body,
                                const Motion& motion,
                                const Imaging& imaging,
                                Rng* rng);

/// Tracks whose images have nothing to do with each other, within a disc of `radius_px`.
std::vector<Track> random_tracks(
    int tracks, int frames, double radius_px, double focal_px, Rng* rng);

}  // namespace polhode::synthetic
