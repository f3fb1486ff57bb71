// Which points move like what is behind the target, and which do not.
//
// One plane motion (homography) at a time, up to three, explains the points that surround the
// middle of the picture: none for a static room, a rotation for stars, a plane for the Earth. What
// contradicts all of them, in a group, is on the target.
#pragma once

#include <array>

#include "mask/points.hpp"

namespace polhode {

/// Motions of the background over the last `age` pictures, from there to the newest.
struct BackgroundMotion {
  static constexpr std::size_t kLayers = 3;

  std::size_t age = 1;
  FixedVector<cv::Matx33d, kLayers> layers;
};

/// What is remembered from picture to picture.
struct BackgroundState {
  /// Pictures over which motion is compared: enough for target and background to differ by 1.5 px,
  /// and twice as many.
  std::size_t age = 1;
  std::array<BackgroundMotion, 2> motions;  ///< over `age` and over twice that
  std::size_t target_tracks = 0;

  // Scratch; contents mean nothing between calls.
  std::vector<cv::Point2f> from, to, group;
  std::vector<std::uint8_t> agrees;
  std::vector<float> contradictions_px;
};

/// Over which of the two ages motions are fitted. One alone tells points apart as well while it is
/// known where the target is.
enum class FittedAges : std::uint8_t { kBoth, kShorter, kLonger };

/// Fits the background's motions and tells the points apart. @param target known parts of the
/// target (CV_8UC1, or empty): their points are no background. @param step working pixels a pixel
/// of it, along a side.
/// @param ages where one alone is asked for and has no motion, the other one is fitted.
/// @return false when no motion of a background was found; all points are unassigned then.
bool explain_background(
    const cv::Mat& target, int step, FittedAges ages, PointsState* points, BackgroundState* state);

/// Little motion of the target against the background: compare over more pictures next time; much:
/// over fewer, in which the target's looks have changed less. Asks the shorter age that has
/// motions.
void choose_age(const PointsState& points, BackgroundState* state);

void clear(BackgroundState* state);

}  // namespace polhode
