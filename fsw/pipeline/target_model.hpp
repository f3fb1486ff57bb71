// The model of a target kept from one pass to the next: its map and unit, inertia and mass centre.
// Another run recognises the target by it, in other light, at another range, with another camera.
//
// The content is the same bytes on every processor, and valid for later builds of its version. The
// caller that stores it checks that it is complete. Each value is checked all the same.
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

/// A content of another version is refused.
inline constexpr std::uint32_t kTargetModelVersion = 1;

/// Summary of a model's content.
struct TargetModelFacts {
  std::uint32_t keyframes = 0;
  std::uint32_t landmarks = 0;
  double radius_mu = 0.0;  ///< 90 % of the landmarks are nearer to their centre
  bool scale_known = false;
  double metres_per_mu = 1.0;
  double scale_sigma = 0.0;  ///< relative
  KnownBody body;
};

/// Upper bound of a model's length in bytes.
std::size_t target_model_octets_max();

/// @param out  at least target_model_octets_max() long.
/// @return bytes written; 0 without a map.
std::size_t save_target_model(const Component& component, std::span<std::uint8_t> out);

/// Into a component that has just been created. The component begins in LOST. It matches the
/// model's landmarks in each frame, and collects frames for a map of its own meanwhile. With the
/// first pose by the model T is the model's, number 1, and lengths are in its unit. A map of its
/// own, in a T with number 2, replaces the model.
/// @errors BadParameter: of another version, truncated, too large for this build's tables, or with
/// values that no component leaves. The component is then as it was created.
Result<TargetModelFacts> load_target_model(std::span<const std::uint8_t> octets,
                                           Component* component);

/// Dates the model's keyframes an hour before the first frame. The motion of this run is not that
/// of the model's keyframes.
void date_target_model(std::int64_t first_frame_ns, Map* map, MotionEstimate* motion);

}  // namespace polhode
