#include "features/resting.hpp"

#include <algorithm>
#include <array>

namespace polhode {
namespace {

// Repeatability of a weak feature's position; of a body's features one passes within it in some
// images.
constexpr float kReach_px = 1.0F;
// Credit of a new place, and its bound: it is dropped after a second or so at 10 frames/s without a
// feature, a place seen for long after three. Chosen.
constexpr std::int32_t kCreditFirst = 10;
constexpr std::int32_t kCreditMost = 30;
// Half the width of a descriptor (descriptor.hpp).
constexpr float kPatch_sigmas = 6.0F;

bool is_within(float reach_px, float u_px, float v_px, const RestingPlace& place) {
  const float du = place.u_px - u_px;
  const float dv = place.v_px - v_px;
  return du * du + dv * dv < reach_px * reach_px;
}

}  // namespace

void add_place(float u_px, float v_px, RestingPlaces* resting) {
  if (!is_resting(u_px, v_px, *resting)) {
    (void)resting->places.push_back({.u_px = u_px, .v_px = v_px, .credit = kCreditFirst});
  }
}

bool is_resting(float u_px, float v_px, const RestingPlaces& resting) {
  return std::any_of(resting.places.begin(), resting.places.end(), [&](const RestingPlace& place) {
    return is_within(kReach_px, u_px, v_px, place);
  });
}

void leave_out_resting(RestingPlaces* resting, Features* features) {
  if (resting->places.empty()) {
    return;
  }
  std::array<bool, RestingPlaces::kPlaces> found{};
  std::size_t kept = 0;
  for (std::size_t i = 0; i < features->size(); ++i) {
    const Feature& feature = (*features)[i];
    const float reach_px = std::max(kReach_px, kPatch_sigmas * feature.scale_px);
    bool rests = false;
    for (std::size_t k = 0; k < resting->places.size(); ++k) {
      const RestingPlace& place = resting->places[k];
      rests |= is_within(reach_px, feature.u_px, feature.v_px, place);
      found[k] |= is_within(kReach_px, feature.u_px, feature.v_px, place);
    }
    if (!rests) {
      (*features)[kept++] = feature;
    }
  }
  features->resize(kept);
  kept = 0;
  for (std::size_t k = 0; k < resting->places.size(); ++k) {
    RestingPlace place = resting->places[k];
    place.credit = std::min(kCreditMost, place.credit + (found[k] ? 1 : -1));
    if (place.credit > 0) {
      resting->places[kept++] = place;
    }
  }
  resting->places.resize(kept);
}

bool is_valid(const RestingPlaces& resting) {
  return resting.places.size() <= resting.places.capacity() &&
         std::all_of(resting.places.begin(), resting.places.end(), [](const RestingPlace& place) {
           return place.credit > 0 && place.credit <= kCreditMost;
         });
}

}  // namespace polhode
