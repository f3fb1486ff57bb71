// Places in the image at which something stays while the body rotates: a caption in a corner, a
// part of the servicer, dirt on the lens. Features there are not of the target, before there is a
// map and with one.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "features/feature.hpp"

namespace polhode {

struct RestingPlace {
  float u_px = 0.0F;  ///< distorted pixel
  float v_px = 0.0F;
  std::int32_t credit = 0;  ///< images with a feature there, less those without; dropped at 0
};

struct RestingPlaces {
  // Chosen: two captions, or an arm. In a full table further places are ignored.
  static constexpr std::size_t kPlaces = 512;
  FixedVector<RestingPlace, kPlaces> places;
};

/// Stores a place, unless there is one beside it.
void add_place(float u_px, float v_px, RestingPlaces* resting);

/// Is the pixel one of the places?
[[nodiscard]] bool is_resting(float u_px, float v_px, const RestingPlaces& resting);

/// Removes the features whose descriptor covers one of the places. A place at which most images
/// have no feature is dropped: the resting object has gone, or it was the body's axis.
void leave_out_resting(RestingPlaces* resting, Features* features);

/// Whether sizes and credits are in their ranges: they are not when bits have flipped in memory.
[[nodiscard]] bool is_valid(const RestingPlaces& resting);

}  // namespace polhode
