// Prior of the mask by the map: place and largest extent of the target.
#pragma once

#include "mask/mask_state.hpp"

namespace polhode {

/// Log-odds under this agree with the background: the negative of the target's limit.
inline constexpr float kAgreement = -kTargetLogOdds;

/// Moving points on the target from which motion alone draws the outline. Chosen: twice the four
/// points of a homography. Larger keeps the map's landmarks in the outline for longer.
inline constexpr std::size_t kTracksEnough = 8;

/// Cells that a known body reaches.
cv::Rect cells_of_body(const MaskPrior& prior);

/// Is there a map that the images did not contradict when it was last placed in one?
bool has_map(const MaskState& state);

/// The working pixel that a pixel of the image is in.
cv::Point working_pixel(const cv::Point2f& p_px, const MaskState& state);

/// Discs around the landmarks, in `map.seeds`. @param contradicted_too  also around those where the
/// log-odds indicate background.
void place_landmarks(const MaskPrior& prior, bool contradicted_too, MaskState* state);

/// Nearer to a landmark than this is target, in working pixels.
double near_px(const MaskState& state);

/// Fills `map`: seeds at the landmarks and between them, and how far the body can reach beyond. No
/// seeds where the log-odds indicate background: a map has some wrong landmarks.
void place_prior(const MaskPrior& prior, MaskState* state);

}  // namespace polhode
