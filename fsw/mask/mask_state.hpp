// The mask's state from image to image.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <span>

#include "mask/appearance.hpp"
#include "mask/background.hpp"
#include "mask/background_model.hpp"
#include "mask/edge_cut.hpp"
#include "mask/foreground.hpp"
#include "mask/outline.hpp"
#include "mask/points.hpp"
#include "mask/target_mask.hpp"

namespace polhode {

/// Prediction of the map's landmarks in this image. No points: there is no map, or no pose.
struct MaskPrior {
  std::span<const cv::Point2f> points_px;  ///< landmarks on the visible face
  double radius_px = 0.0;                  ///< of the body
};

/// The prior in the newest image. All of it has the size of the log-odds.
struct MapRegions {
  double radius_px = 0.0;  ///< of the body, in working pixels
  cv::Mat landmark_discs;  ///< CV_8UC1: around the landmarks that the images do not contradict
  cv::Mat seeds;       ///< CV_8UC1: fixed as target by the map, where motion alone does not decide
  cv::Rect seeds_box;  ///< around all of them
  cv::Mat reach;       ///< CV_8UC1: largest extent of the target. Empty: no map, or the images
                       ///< contradict all of it
  cv::Mat distance;    ///< CV_32FC1: to the landmarks, in working pixels
};

/// Working memory; contents mean nothing between calls.
struct MaskScratch {
  OutlineScratch outline;
  AppearanceScratch appearance;
  ImageEdges edges;
  cv::Mat enclosed;     ///< CV_8UC1, size of the log-odds: the cells that they enclose
  cv::Mat cell_values;  ///< CV_32FC1, size of the log-odds: distance to gaps in the prior, then the
                        ///< unary cost of the cut
  cv::Mat open, cells, added;
};

/// The state of this room.
struct MaskState {
  PointsState points;
  BackgroundState background;
  ForegroundState foreground;
  BackgroundModel background_model;
  std::size_t compared = 0;  ///< images since something was behind the target
  bool behind = false;       ///< something is behind the target: the image border is lit
  bool found = false;        ///< `outline` contains the target
  bool was_found = false;    ///< in the image before
  bool sharp = false;        ///< `outline` has been moved to image edges
  // Images since the last whose background had a motion. Begins as after many without one.
  int unexplained = 1000;
  cv::Mat outline;  ///< CV_8UC1 of the working size, 255 on the target; not grown
  MapRegions map;
  MaskScratch scratch;
};

}  // namespace polhode
