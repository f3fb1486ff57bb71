// Points followed from picture to picture, all over the picture and closer together on the target.
//
// Works on the picture halved until it is at most kWorkingWidthMax_px across ("working pixels").
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "base/fixed_vector.hpp"

namespace polhode {

inline constexpr int kWorkingWidthMax_px = 640;

/// Pixels of a picture per working pixel: a power of two, as halving is the cheap way to reduce.
constexpr int decimation_of(int width_px) {
  const int least = (width_px + kWorkingWidthMax_px - 1) / kWorkingWidthMax_px;
  return static_cast<int>(std::bit_ceil(static_cast<unsigned>(least)));
}

enum class TrackClass : std::uint8_t { kUnassigned, kBackground, kTarget };

/// A point where it was in the last pictures, in working pixels.
struct MaskTrack {
  static constexpr std::size_t kPlaces = 16;

  std::array<cv::Point2f, kPlaces> places;  ///< newest first
  std::size_t count = 0;                    ///< of these that are known
  TrackClass kind = TrackClass::kUnassigned;

  [[nodiscard]] cv::Point2f now() const { return places[0]; }
  /// Motion over the last `age` pictures, at the rate of those that are known.
  [[nodiscard]] cv::Point2f motion(std::size_t age) const;
};

/// What optical flow wants of a picture: reduced pictures and their gradients.
using FlowPyramid = std::vector<cv::Mat>;

/// What is remembered from picture to picture. Memory is taken with the first picture.
struct PointsState {
  static constexpr std::size_t kPictures = MaskTrack::kPlaces;
  static constexpr std::size_t kTracks = 420;

  int decimation = 1;                       ///< pixels of the image per working pixel
  std::array<cv::Mat, kPictures> pictures;  ///< ring
  FlowPyramid pyramid;                      ///< of the newest picture
  FlowPyramid pyramid_before;               ///< of the one before it
  std::size_t newest = 0;
  std::size_t stored = 0;
  std::size_t turn =
      0;  ///< where points are looked for next: the bands of the picture, the target between
  FixedVector<MaskTrack, kTracks> tracks;
  bool onwards = false;  ///< points whose motion is known are looked for where that brings them,
                         ///< else all around where they were
  float error_before =
      0.0F;  ///< how unlike points typically were in the newest picture and the one before, levels

  // Scratch; contents mean nothing between calls.
  cv::Mat corner_score;
  std::vector<cv::Point2f> from, to;
  std::vector<std::uint8_t> found;
  std::vector<float> error;

  /// The picture `age` pictures ago.
  [[nodiscard]] const cv::Mat& picture(std::size_t age) const {
    return pictures[(newest + kPictures - age) % kPictures];
  }
  [[nodiscard]] cv::Rect whole() const { return {cv::Point(), picture(0).size()}; }
};

/// Reduces a picture and stores it. @return whether it is the first, or the first of its size.
/// @param reduced  the same picture, reduced before by some power of two, or empty: taken where it
/// is what would be stored
bool add_picture(const cv::Mat& gray, const cv::Mat& reduced, PointsState* state);

/// Follows all points from the picture before to the newest one; those that are lost go.
void follow_points(PointsState* state);

/// Follows points of a class back to the picture before: those that do not come back to where they
/// were go. Noise and rims make points move unlike anything.
void drop_stray_points(TrackClass kind, PointsState* state);

/// Where new points are looked for: in the target each time while it has few, and
enum class Refill : std::uint8_t {
  kEverywhere,     ///< in the whole picture and in the target
  kBandAndTarget,  ///< in the next quarter of the picture and in the target
  kByTurns         ///< in one of these, and of the target in one half: less than half of the cost
};

/// New points where there are none, closer together in `target`, which may be empty.
void refill_points(const cv::Rect& target, Refill where, PointsState* state);

void clear(PointsState* state);

}  // namespace polhode
