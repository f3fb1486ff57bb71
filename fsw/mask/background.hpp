// Classifies points by the motion of the background.
// Up to three plane motions (homographies) explain the points around the middle of the image: a
// room at rest, rotating stars, the Earth as a plane. A group of points that contradicts all of
// them is on the target.
#pragma once

#include <array>

#include "mask/points.hpp"

namespace polhode {

/// Motions of the background over the last `age` images, from there to the newest.
struct BackgroundMotion {
  // Chosen: a room has several planes. Each more costs a look-up of every compared pixel.
  static constexpr std::size_t kLayers = 3;
  // Points of a layer: over twice the four that any homography fits. Chosen; larger misses small
  // backgrounds, smaller fits chance.
  static constexpr std::size_t kLayerTracksMin = 10;

  std::size_t age = 1;
  FixedVector<cv::Matx33d, kLayers> layers;
};

/// The state of the background's classification.
struct BackgroundState {
  /// images over which motion is compared: enough for target and background to differ by 1.5 px
  std::size_t age = 1;
  std::array<BackgroundMotion, 2> motions;  ///< over `age` and over twice that
  std::size_t target_tracks = 0;

  // Scratch; contents mean nothing between calls.
  std::vector<cv::Point2f> from, to, group;
  std::vector<std::uint8_t> agrees;
  std::vector<float> contradictions_px;
};

/// Ages over which motions are fitted. While the target's place is known, one of them separates the
/// points as well as both.
enum class FittedAges : std::uint8_t { kBoth, kShorter, kLonger };

/// Fits the background's motions and classifies the points. @param target known parts of the target
/// (CV_8UC1, or empty): their points are no background. @param step working pixels per pixel of it,
/// along a side.
/// @param ages where one alone is requested and has no motion, the other one is fitted.
/// @return false when no motion of a background was found; all points are unassigned then.
bool explain_background(
    const cv::Mat& target, int step, FittedAges ages, PointsState* points, BackgroundState* state);

/// Chooses the age for the next image, by the shortest age that has motions. The age grows when the
/// target moves little against the background, and falls when it moves much, as its appearance then
/// changes less.
void choose_age(const PointsState& points, BackgroundState* state);

void clear(BackgroundState* state);

}  // namespace polhode
