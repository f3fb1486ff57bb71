// What the map predicts of the image: where the target is, and how far it can reach.
#pragma once

#include "mask/mask_state.hpp"

namespace polhode {

/// Log-odds under this agree with the background: as far from 0 as what counts as target.
inline constexpr float kAgreement = -kTargetLogOdds;

/// With so many moving points on the target, motion alone draws the outline. Chosen: twice the four
/// points of a homography. Larger keeps the map's landmarks in the outline for longer.
inline constexpr std::size_t kTracksEnough = 8;

/// Cells that a known body reaches.
cv::Rect cells_of_body(const MaskPrior& prior);

/// There is a map, and the images did not contradict it when it was last placed in one.
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
