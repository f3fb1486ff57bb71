// Points tracked from image to image, all over the image and closer together on the target.
// Works on the image halved until its longer side is at most kWorkingSideMax_px ("working pixels").
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "base/fixed_vector.hpp"

namespace polhode {

// 480 at 1920: overlaps as with 640, in two thirds of the time. With 240 they are 0.88 and 0.84
// instead of 0.91 and 0.91 (decision 0009).
inline constexpr int kWorkingSideMax_px = 640;

/// Pixels of an image per working pixel: a power of two, as halving is the cheap way to reduce.
/// Upright images as lying ones.
constexpr int decimation_of(int width_px, int height_px) {
  const int longer_px = std::max(width_px, height_px);
  const int least = (longer_px + kWorkingSideMax_px - 1) / kWorkingSideMax_px;
  return static_cast<int>(std::bit_ceil(static_cast<unsigned>(least)));
}

enum class TrackClass : std::uint8_t { kUnassigned, kBackground, kTarget };

/// Positions of a point in the last images, in working pixels.
struct MaskTrack {
  // Length of the history; motion is compared over up to 14 images, twice the largest age. Chosen;
  // larger lets slower targets show their motion, and takes more memory.
  static constexpr std::size_t kPlaces = 16;

  std::array<cv::Point2f, kPlaces> places;  ///< newest first
  std::size_t count = 0;                    ///< number of known places
  TrackClass kind = TrackClass::kUnassigned;

  [[nodiscard]] cv::Point2f now() const { return places[0]; }
  /// Motion over the last `age` images, at the rate of the known places.
  [[nodiscard]] cv::Point2f motion(std::size_t age) const;
};

/// Input of the optical flow: reduced images and their gradients.
using FlowPyramid = std::vector<cv::Mat>;

/// The state of the points. Memory is taken with the first image.
struct PointsState {
  static constexpr std::size_t kImages = MaskTrack::kPlaces;
  // Capacity: the whole image takes up to 240 points, a target up to 200. Chosen; drop_lonely
  // compares them by pairs.
  static constexpr std::size_t kTracks = 420;

  int decimation = 1;                   ///< pixels of the image per working pixel
  std::array<cv::Mat, kImages> images;  ///< ring
  FlowPyramid pyramid;                  ///< of the newest image
  FlowPyramid pyramid_before;           ///< of the one before it
  std::size_t newest = 0;
  std::size_t stored = 0;
  std::size_t turn = 0;  ///< where points are added next: the image's bands by turns, the target in
                         ///< between
  FixedVector<MaskTrack, kTracks> tracks;
  bool predicted = false;     ///< the search begins at a point's predicted place, else at its last
                              ///< one, and on all levels
  float error_before = 0.0F;  ///< typical difference of points in the two newest images, levels

  // Scratch; contents mean nothing between calls.
  cv::Mat corner_score;
  std::vector<cv::Point2f> from, to;
  std::vector<std::uint8_t> found;
  std::vector<float> error;

  /// The image `age` images ago.
  [[nodiscard]] const cv::Mat& image(std::size_t age) const {
    return images[(newest + kImages - age) % kImages];
  }
  [[nodiscard]] cv::Rect whole() const { return {cv::Point(), image(0).size()}; }
};

/// Reduces an image and stores it. @return whether it is the first, or the first of its size.
/// @param reduced  the same image, reduced before by some power of two, or empty: stored where its
/// size is right
bool add_image(const cv::Mat& gray, const cv::Mat& reduced, PointsState* state);

/// Tracks all points from the image before to the newest one; lost ones are dropped.
void follow_points(PointsState* state);

/// Tracks points of a class back to the image before, and drops those that do not return: noise and
/// silhouettes move points unlike any surface.
void drop_stray_points(TrackClass kind, PointsState* state);

/// Where new points are searched for. In the target each time while it has few, and:
enum class Refill : std::uint8_t {
  kEverywhere,     ///< in the whole image and in the target
  kBandAndTarget,  ///< in the next quarter of the image and in the target
  kByTurns         ///< in one of these, and of the target in one half: less than half of the cost
};

/// Adds points in tiles without one, closer together in `target`, which may be empty.
void refill_points(const cv::Rect& target, Refill where, PointsState* state);

void clear(PointsState* state);

}  // namespace polhode
