// The target's mask from image to image: by light, by motion unlike the background's, and by the
// map.
#pragma once

#include <opencv2/core.hpp>

#include "mask/mask_state.hpp"
#include "mask/options.hpp"
#include "mask/target_mask.hpp"

namespace polhode {

/// Before black space: leaves the mask as it is. With something behind the target: keeps the piece
/// of the image that contradicts the background's motion, or that contains the map's landmarks.
/// Without such a piece the mask is empty. When no motion has explained the background for five
/// images, everything lit is the target.
/// @param mask as find_target makes it of the same image
/// @cost about 3 ms an image of 1920 x 1080.
void follow_target(const cv::Mat& gray,
                   const MaskPrior& prior,
                   const MaskOptions& options,
                   MaskState* state,
                   TargetMask* mask);

/// Does everything lit count as target, because no motion has explained the background for some
/// images?
bool is_open(const MaskState& state);

/// May the mask include background? It is open, and points are followed along the image border. Or
/// the outline before a lit background covers a tenth of the border.
bool may_be_background(const MaskState& state);

/// For keyframes, after follow_target: moves the outline to image edges. With a map the result is
/// stored as log-odds. Does nothing before black space. Where the cut leaves no outline, the old
/// one stays and is not sharp.
/// @cost with a map about 1.4 ms for a target of a quarter of the image, before one ten times as
/// much.
void sharpen_outline(MaskState* state);

/// Before a map, after sharpen_outline: opens the inside of the sharpened outline to features, and
/// one working pixel around it. Not where the background is seen. The outline by motion alone lacks
/// much of the silhouette, where initialisation sees depth.
void open_outline(const cv::Size& image_px, MaskState* state, TargetMask* mask);

/// Resets the state to that before the first image.
void clear(MaskState* state);

/// Does the sharpened outline rule out a new landmark at this pixel of the image? Only farther from
/// it than its error; never where the outline was not sharpened.
bool rules_out(const MaskState& state, float u_px, float v_px);

}  // namespace polhode
