// A body of spots with looks, keyframes about it, and the map that a perfect mapper would have made
// of them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "map/map.hpp"
#include "solve/bundle_adjustment.hpp"

namespace polhode::synthetic {

/// As RootSIFT makes them: bytes of norm 512, unrelated ones some 500 apart.
inline Descriptor random_look(Rng* rng) {
  std::array<double, 128> values{};
  double sum = 0.0;
  for (double& v : values) {
    v = std::pow(std::log(1.0 - rng->uniform()), 2);
    sum += v;
  }
  Descriptor d;
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = static_cast<std::uint8_t>(std::min(255.0, 512.0 * std::sqrt(values[i] / sum)));
  }
  return d;
}

inline Descriptor another_view(const Descriptor& look, Rng* rng) {
  constexpr double kSigma = 9.0;  // 9 * sqrt(128) is about 100, twice that between two views
  Descriptor d;
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = static_cast<std::uint8_t>(std::clamp(look[i] + kSigma * rng->normal(), 0.0, 255.0));
  }
  return d;
}

inline Eigen::Vector3d normal3(Rng* rng) { return {rng->normal(), rng->normal(), rng->normal()}; }

struct Spot {
  Eigen::Vector3d p_T = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_T = Eigen::Vector3d::UnitZ();
  Descriptor look{};
};

inline constexpr double kSpotSize_mu = 0.03;
inline constexpr double kNoise_px = 0.5;
inline constexpr double kDistance_mu = 8.0;

inline CameraModel camera() {
  return {.width_px = 640,
          .height_px = 480,
          .fu_px = 1500.0,
          .fv_px = 1500.0,
          .cu_px = 320.0,
          .cv_px = 240.0};
}

/// Spots on a ball of radius 1.
inline std::vector<Spot> ball(int spots, std::uint64_t seed) {
  Rng rng(seed, 91);
  std::vector<Spot> body;
  for (int i = 0; i < spots; ++i) {
    const Eigen::Vector3d n = normal3(&rng).normalized();
    body.push_back({.p_T = n, .normal_T = n, .look = random_look(&rng)});
  }
  return body;
}

/// The body turned by `angle_rad` about an axis near the image's vertical.
inline Pose turned(double angle_rad) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.15, 1.0, -0.1).normalized();
  return {.R_CT = so3_exp(angle_rad * axis), .p_CT = {0.05, -0.03, kDistance_mu}};
}

struct Picture {
  std::unique_ptr<Features> features = std::make_unique<Features>();
  std::vector<int> spot_of;  ///< per feature; -1: clutter
};

/// The features that a camera sees of the body: sides that face it, with noise, then clutter that
/// is nothing.
inline Picture take_image(
    const std::vector<Spot>& body, const Pose& pose, double noise_px, int clutter, Rng* rng) {
  Picture image;
  const CameraModel model = camera();
  const auto add =
      [&](const Eigen::Vector2d& pixel, double scale_px, const Descriptor& look, int spot) {
        Feature f;
        f.u_px = static_cast<float>(pixel.x());
        f.v_px = static_cast<float>(pixel.y());
        f.normalised = undistort(model, {static_cast<double>(f.u_px), static_cast<double>(f.v_px)});
        f.sigma_px = static_cast<float>(kNoise_px);
        f.scale_px = static_cast<float>(scale_px);
        f.descriptor = look;
        if (image.features->push_back(f)) {
          image.spot_of.push_back(spot);
        }
      };
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Eigen::Vector3d p_C = pose.to_camera(body[i].p_T);
    const double facing = (pose.R_CT * body[i].normal_T).dot(-p_C.normalized());
    const Eigen::Vector2d pixel =
        project_px(model, p_C) + noise_px * Eigen::Vector2d(rng->normal(), rng->normal());
    if (facing > 0.4 && pixel.x() > 0.0 && pixel.y() > 0.0 && pixel.x() < 639.0 &&
        pixel.y() < 479.0) {
      add(pixel,
          kSpotSize_mu * model.focal_px() / p_C.z(),
          another_view(body[i].look, rng),
          static_cast<int>(i));
    }
  }
  for (int i = 0; i < clutter; ++i) {
    add({640.0 * rng->uniform(), 480.0 * rng->uniform()},
        2.0 + 8.0 * rng->uniform(),
        random_look(rng),
        -1);
  }
  return image;
}

struct SyntheticMap {
  std::unique_ptr<Map> map = std::make_unique<Map>();
  std::vector<KeyframeId> keyframes;
  std::vector<LandmarkId> landmark_of;  ///< per spot; invalid where no two keyframes see it
};

/// Every spot that two images see becomes a landmark at its true place, except those from
/// `mapped_spots` on.
inline SyntheticMap make_map(const std::vector<Spot>& body,
                             const std::vector<Pose>& poses,
                             double noise_px,
                             std::uint64_t seed,
                             std::size_t mapped_spots = 1000000) {
  Rng rng(seed, 92);
  SyntheticMap s;
  s.landmark_of.resize(body.size());
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> seen(body.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Picture image = take_image(body, poses[k], noise_px, 0, &rng);
    const KeyframeId id = add_keyframe(s.map.get());
    Keyframe& keyframe = s.map->keyframes[id.index()];
    keyframe.frame = static_cast<std::uint32_t>(k);
    keyframe.timestamp_ns = static_cast<std::int64_t>(k) * 1'000'000'000;
    keyframe.pose = poses[k];
    keyframe.features = *image.features;
    s.keyframes.push_back(id);
    for (std::size_t i = 0; i < image.spot_of.size(); ++i) {
      seen[static_cast<std::size_t>(image.spot_of[i])].emplace_back(k, i);
    }
  }
  for (std::size_t spot = 0; spot < std::min(body.size(), mapped_spots); ++spot) {
    if (seen[spot].size() < 2) {
      continue;
    }
    const LandmarkId id = add_landmark(s.map.get());
    s.landmark_of[spot] = id;
    s.map->landmarks[id.index()].p_T = body[spot].p_T;
    for (const auto& [k, feature] : seen[spot]) {
      add_observation(s.keyframes[k], feature, id, s.map.get());
    }
  }
  refresh_landmarks(s.map.get(), camera());
  return s;
}

/// Poses every `step_rad` from 0 on.
inline std::vector<Pose> turn_by(double step_rad, int count) {
  std::vector<Pose> poses;
  for (int k = 0; k < count; ++k) {
    poses.push_back(turned(step_rad * k));
  }
  return poses;
}

/// What holds of a map at any time. @return text of the first promise that is broken, or empty.
inline std::string broken_promise(const Map& map) {
  std::vector<int> associations(map.landmarks.size(), 0);
  std::vector<std::uint32_t> numbers;
  for (const Keyframe& keyframe : map.keyframes) {
    if (!keyframe.used) {
      continue;
    }
    numbers.push_back(keyframe.number);
    for (std::size_t i = 0; i < keyframe.landmark_of.size(); ++i) {
      const LandmarkId id = keyframe.landmark_of[i];
      if (!id.valid()) {
        continue;
      }
      if (i >= keyframe.features.size()) {
        return "a tie without a feature";
      }
      if (!map.landmarks[id.index()].used) {
        return "a tie to a landmark that is gone";
      }
      ++associations[id.index()];
    }
  }
  int landmarks = 0;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (map.landmarks[i].used) {
      ++landmarks;
      if (map.landmarks[i].observations != associations[i]) {
        return "a landmark's observations are not its ties";
      }
    }
  }
  std::sort(numbers.begin(), numbers.end());
  if (std::adjacent_find(numbers.begin(), numbers.end()) != numbers.end()) {
    return "two keyframes have one number";
  }
  if (landmarks != map.landmark_count || static_cast<int>(numbers.size()) != map.keyframe_count) {
    return "the counts are wrong";
  }
  return {};
}

}  // namespace polhode::synthetic
