// The target's mask from picture to picture: what is bright, what moves unlike the background, and
// what the map says.
#pragma once

#include <opencv2/core.hpp>

#include "mask/mask_state.hpp"
#include "mask/options.hpp"
#include "mask/target_mask.hpp"

namespace polhode {

/// Before black space: leaves the mask as it is. With something behind the target: the piece of the
/// picture that contradicts the background's motion, or that the map's landmarks are in. While
/// there is no such piece the mask is empty; where the background had no motion that explains it
/// either, not for five pictures, everything lit is the target.
/// @param mask as find_target makes it of the same picture
/// @cost about 3 ms a picture of 1920 x 1080.
void follow_target(const cv::Mat& gray,
                   const MaskPrior& prior,
                   const MaskOptions& options,
                   MaskState* state,
                   TargetMask* mask);

/// For keyframes, after follow_target: moves the outline to the picture's edges. With a map it
/// becomes the evidence that goes along. Nothing is done before black space; where no outline is
/// left, it stays as it was and is not sharp.
/// @cost with a map about 1.4 ms for a target of a quarter of the picture, before one ten times as
/// much.
void sharpen_outline(MaskState* state);

/// Before a map, after sharpen_outline: opens to features what is inside the sharpened outline,
/// save where the background is seen, and a working pixel more all around. What moves alone lacks
/// much of a body's rim, and there it is that a start sees depth.
void open_outline(const cv::Size& image_px, MaskState* state, TargetMask* mask);

/// As if no picture had been seen; what is asked about outlines stays.
void clear(MaskState* state);

/// Does the sharpened outline rule out that there is something new of the target at this pixel of
/// the image? Not nearer than outlines are off, and never where the picture's outline was not
/// sharpened.
bool rules_out(const MaskState& state, float u_px, float v_px);

}  // namespace polhode
