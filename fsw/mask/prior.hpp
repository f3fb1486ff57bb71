// What the map says of the picture: where the target is, and how far it can reach.
#pragma once

#include "mask/mask_state.hpp"

namespace polhode {

/// Evidence under this: moves like the background.
inline constexpr float kAgreement = -0.3F;

/// So many points of the target that move tell where it is.
inline constexpr std::size_t kTracksEnough = 8;

/// Cells that a known body reaches.
cv::Rect cells_of_body(const MaskPrior& prior);

/// There is a map, and the pictures did not contradict it when it was last placed in one.
bool has_map(const MaskState& state);

/// The working pixel that a pixel of the image is in.
cv::Point working_pixel(const cv::Point2f& p_px, const MaskState& state);

/// Discs about the landmarks, in `certain`. @param contradicted_too  those, too, that are where the
/// pictures say background.
void place_landmarks(const MaskPrior& prior, bool contradicted_too, MaskState* state);

/// Nearer to a landmark than this is target, in working pixels.
double near_px(const MaskState& state);

/// Landmarks are certain, and so is what lies between them, unless the pictures say that the
/// background is there: a map has some that are wrong. And how far the body can reach beyond them.
void place_prior(const MaskPrior& prior, MaskState* state);

}  // namespace polhode
