// The servicer's own structure in the image, known beforehand: never target.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

struct MaskState;
struct TargetMask;

struct OwnStructure {
  cv::Mat pixels;   ///< CV_8UC1, not 0 where the servicer is seen
  cv::Mat cells;    ///< CV_8UC1, size of TargetMask::cells, 255 where no feature is taken
  cv::Mat working;  ///< CV_8UC1, in working pixels of mask/points.hpp, 255 where no target can be
};

/// @param pixels CV_8UC1 of the image's size, not 0 where the servicer is seen; kept, not copied.
OwnStructure own_structure(const cv::Mat& pixels);

/// Blackens the structure in an image, like empty space, for all later stages.
void blacken(const OwnStructure& own, cv::Mat* gray);

/// Closes the cells that it reaches to features, and two cells around them: its silhouette stays in
/// place in the image.
void close_cells(const OwnStructure& own, TargetMask* mask);

/// Removes the structure from the outline, and drops the points that are followed on it or along
/// its silhouette: before a moving background they would be taken for the target.
void leave_out(const OwnStructure& own, MaskState* state);

}  // namespace polhode
