// What a pass by a target leaves for the next one: its map and unit, inertia and mass centre.
// Another run recognises the target by it, in other light, at another range, with another camera.
//
// The content is the same octets on every processor, and holds for later builds of its version.
// Whoever stores it checks that it is whole. Each value is checked all the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/result.hpp"
#include "motion/known_body.hpp"
#include "pipeline/component.hpp"

namespace polhode {

struct Map;
struct MotionEstimate;

/// Of a content that another version wrote nothing is read.
inline constexpr std::uint32_t kTargetModelVersion = 1;

/// What a model says of itself.
struct TargetModelFacts {
  std::uint32_t keyframes = 0;
  std::uint32_t landmarks = 0;
  double radius_mu = 0.0;  ///< 90 % of the landmarks are nearer to their middle
  bool scale_known = false;
  double metres_per_mu = 1.0;
  double scale_sigma = 0.0;  ///< relative
  KnownBody body;
};

/// Octets that no model is longer than.
std::size_t target_model_octets_max();

/// @param out  at least target_model_octets_max() long.
/// @return octets written; 0 without a map.
std::size_t save_target_model(const Component& component, std::span<std::uint8_t> out);

/// Into a component that has just been created. It begins as one that has lost its target: it looks
/// for it by the model's landmarks in each frame, and collects for a map of its own meanwhile. With
/// the first pose by the model T is the model's, number 1, and lengths are in its unit. A map of
/// its own, in a T with number 2, takes the model's place.
/// @errors BadParameter: of another version, cut off, too large for this build's tables, or with
/// values that no component leaves. The component is then as it was created.
Result<TargetModelFacts> load_target_model(std::span<const std::uint8_t> octets,
                                           Component* component);

/// The model's keyframes are of a time before all frames: an hour before this one, which is the
/// first. Nothing that holds for their motion holds for this one's.
void date_target_model(std::int64_t first_frame_ns, Map* map, MotionEstimate* motion);

}  // namespace polhode
