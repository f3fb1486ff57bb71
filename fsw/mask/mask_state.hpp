// What is remembered of the target's mask from picture to picture.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <span>

#include "mask/appearance.hpp"
#include "mask/background.hpp"
#include "mask/background_model.hpp"
#include "mask/edge_cut.hpp"
#include "mask/evidence.hpp"
#include "mask/network.hpp"
#include "mask/outline.hpp"
#include "mask/points.hpp"
#include "mask/refine.hpp"
#include "mask/target_mask.hpp"

namespace polhode {

/// Where the map's landmarks should be in this picture. No points: there is no map, or no pose.
struct MaskPrior {
  std::span<const cv::Point2f> points_px;  ///< landmarks on the side that is seen
  double radius_px = 0.0;                  ///< of the body
};

/// What is remembered from picture to picture.
struct MaskState {
  PointsState points;
  BackgroundState background;
  EvidenceState evidence;
  BackgroundModel background_model;
  std::size_t compared = 0;  ///< pictures since something was behind the target
  bool behind = false;       ///< something is behind the target: the rim of the picture is lit
  bool found = false;        ///< `outline` holds the target
  bool was_found = false;    ///< in the picture before
  bool sharp = false;        ///< `outline` has been moved to the picture's edges
  int unexplained = 1000;    ///< pictures since the last whose background had a motion
  cv::Mat outline;           ///< CV_8UC1 of the working size, 255 on the target; not grown
  double radius_px = 0.0;    ///< of the body by the map, in working pixels
  // Of the evidence's size, as `certain_box` is in its pixels.
  cv::Mat enclosed;      ///< CV_8UC1: what the evidence encloses
  cv::Mat landmarks;     ///< CV_8UC1: about the map's landmarks that the pictures do not contradict
  cv::Mat certain;       ///< CV_8UC1: target by the map, where motion alone does not tell
  cv::Rect certain_box;  ///< about all of that
  cv::Mat reach;     ///< CV_8UC1: as far as the target can be by the map; empty: there is none, or
                     ///< pictures contradict it
  cv::Mat distance;  ///< CV_32FC1: to those landmarks, in working pixels
  MaskNetwork network;  ///< asked about the outlines of keyframes, where there is one
  OutlineScratch scratch;
  AppearanceScratch appearance_scratch;
  RefineScratch refine_scratch;
  PictureEdges edges;
  cv::Mat opinion, open, cells, added;  ///< scratch
};

}  // namespace polhode
