// Places where something stays in the image while the body turns: a word in a corner, a piece of
// the servicer, dirt on the lens. It is no target, before there is a map and with one.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "features/feature.hpp"

namespace polhode {

struct RestingPlace {
  float u_px = 0.0F;  ///< distorted pixel
  float v_px = 0.0F;
  std::int32_t credit = 0;  ///< images with a feature there, less those without; it goes at 0
};

struct RestingPlaces {
  // Chosen: two captions, or an arm. What finds no room takes features as before.
  static constexpr std::size_t kPlaces = 512;
  FixedVector<RestingPlace, kPlaces> places;
};

/// Remembers a place, unless one beside it is remembered.
void add_place(float u_px, float v_px, RestingPlaces* resting);

/// Is the pixel one of the places?
[[nodiscard]] bool is_resting(float u_px, float v_px, const RestingPlaces& resting);

/// Removes the features whose descriptor covers one of the places. A place at which most images
/// have no feature is dropped: the resting object has gone, or it was the body's axis.
void leave_out_resting(RestingPlaces* resting, Features* features);

/// Whether sizes and credits are such as they are made, as long as no bit has flipped in memory.
[[nodiscard]] bool is_valid(const RestingPlaces& resting);

}  // namespace polhode
