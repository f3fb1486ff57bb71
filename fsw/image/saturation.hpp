// Where the sensor has bled.
#pragma once

#include <opencv2/core/mat.hpp>

namespace polhode {

/// Is there a saturated pixel within 3 px (rows and columns) of a point? The edge of a glint stays
/// where it is while the body turns, and what lies under it is not seen.
/// @param saturated_level fraction of full scale. A point outside the picture is near nothing.
bool near_saturated(const cv::Mat& gray, double u_px, double v_px, double saturated_level);

}  // namespace polhode
