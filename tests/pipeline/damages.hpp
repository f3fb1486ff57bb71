// A component with a map, and what bit flips may do to what it remembers.
#pragma once

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>

#include "bench.hpp"
#include "pipeline/checkpoint.hpp"
#include "pipeline/soundness.hpp"
#include "state_of.hpp"

namespace polhode::bench {

inline constexpr int kFrames = 18;
inline constexpr int kFramesBefore = 14;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline const StepOutput& show(Bench& b, int frame) {
  static const std::vector<Picture> rendered = images_of_turning(kFrames);
  return b.component->step({.frame = frame_of((frame + 1) * Bench::kSecond_ns,
                                              rendered[static_cast<std::size_t>(frame)])});
}

inline std::vector<std::uint8_t> saved(const Bench& b) {
  std::vector<std::uint8_t> octets(checkpoint_octets_max());
  octets.resize(save_checkpoint(*b.component, octets));
  return octets;
}

/// With a map, a model, and every table in use.
inline const std::vector<std::uint8_t>& good_checkpoint() {
  static const std::vector<std::uint8_t> octets = [] {
    Bench b(parameters());
    for (int i = 0; i < kFramesBefore; ++i) {
      show(b, i);
      EXPECT_TRUE(is_valid(state_of(*b.component))) << "frame " << i;
    }
    EXPECT_GT(state_of(*b.component).mapping.map.keyframe_count, 0);
    EXPECT_FALSE(state_of(*b.component).motion.recent.empty());
    return saved(b);
  }();
  return octets;
}

inline Keyframe& first_keyframe(Component::State& s) {
  return *std::find_if(s.mapping.map.keyframes.begin(),
                       s.mapping.map.keyframes.end(),
                       [](const Keyframe& keyframe) { return keyframe.used; });
}

inline Landmark& first_landmark(Component::State& s) {
  return *std::find_if(s.mapping.map.landmarks.begin(),
                       s.mapping.map.landmarks.end(),
                       [](const Landmark& landmark) { return landmark.used; });
}

struct Damage {
  const char* what;
  std::function<void(Component::State&)> done;
};

inline const std::vector<Damage>& damages() {
  static const std::vector<Damage> list{
      {"a tie to no landmark",
       [](auto& s) { first_keyframe(s).landmark_of[0].slot = limits::kLandmarks; }},
      {"a tie below the table", [](auto& s) { first_keyframe(s).landmark_of[0].slot = -7; }},
      {"keyframes' count", [](auto& s) { s.mapping.map.keyframe_count += 1; }},
      {"landmarks' count", [](auto& s) { s.mapping.map.landmark_count -= 1; }},
      {"observations", [](auto& s) { first_landmark(s).observations += 4; }},
      {"a keyframe's attitude", [](auto& s) { first_keyframe(s).pose.R_CT(0, 0) += 1e-3; }},
      {"a keyframe's number", [](auto& s) { first_keyframe(s).number += 1U << 20U; }},
      {"a keyframe's time", [](auto& s) { first_keyframe(s).timestamp_ns = 1LL << 62; }},
      {"a feature outside", [](auto& s) { first_keyframe(s).features[0].u_px = 1e6F; }},
      {"a landmark's place", [](auto& s) { first_landmark(s).p_T.x() = kNan; }},
      {"a landmark too far", [](auto& s) { first_landmark(s).p_T.x() = 1e200; }},
      {"the map's extent", [](auto& s) { s.mapping.map.radius_mu = -1.0; }},
      {"the drift", [](auto& s) { s.mapping.drift.walk(2, 2) = -1.0; }},
      {"a pose's covariance", [](auto& s) { s.motion.recent[0].covariance(0, 0) = -1.0; }},
      {"the order of poses", [](auto& s) { s.motion.past[0].timestamp_ns = s.clock.timestamp_ns; }},
      {"the last pose seen", [](auto& s) { s.motion.last_seen.pose_C.pose.R_CT(0, 0) += 1e-3; }},
      {"the model's kind", [](auto& s) { s.motion.model.status = static_cast<ModelStatus>(9); }},
      {"the scale", [](auto& s) { s.scale.metres_per_mu = 0.0; }},
      {"what was found of the camera", [](auto& s) { s.camera.found.value[0] = kNan; }},
      {"resting places",
       [](auto& s) { (void)s.features.resting.places.push_back({.credit = 1 << 20}); }},
      {"a flag", [](auto& s) { std::memset(&s.scale.known, 0x40, 1); }},
      {"a parameter", [](auto& s) { s.configuration.parameters.features.count_max ^= 1; }},
      {"a sequence count", [](auto& s) { s.bus.stream.sequence[0] = 0x4000; }},
      {"the scale's number", [](auto& s) { s.bus.scale.unit.metres_per_mu = -1.0; }},
      {"the servicer's attitude", [](auto& s) { s.bus.servicer.q_IC.w() = 3.0; }},
      {"the reported mode", [](auto& s) { s.bus.reported.mode = static_cast<Mode>(200); }}};
  return list;
}

}  // namespace polhode::bench
