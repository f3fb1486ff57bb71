// Which part of the picture moves like what is behind the target.
//
// Works on the picture reduced to at most 320 px across. What fills the rim of the picture is the
// background: its points are followed from an earlier picture, one plane motion (homography) at a
// time explains them (none for a static room, a rotation for stars, a plane for the Earth), and
// where the picture contradicts all of these motions, something else moves.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "base/fixed_vector.hpp"

namespace polhode {

enum class TrackClass : std::uint8_t { kUnassigned, kBackground, kTarget };

/// A point followed from the reference picture to this one, in pixels of the working picture.
struct MaskTrack {
  cv::Point2f from;
  cv::Point2f to;
  TrackClass kind = TrackClass::kUnassigned;
};

/// What is remembered from picture to picture. Memory is taken with the first picture.
struct BackgroundState {
  static constexpr std::size_t kPictures = 16;
  static constexpr std::size_t kTracks = 160;
  static constexpr std::size_t kLayers = 3;
  static constexpr float kEvidenceMax = 6.0F;

  int decimation = 1;  ///< pixels of the image per working pixel
  std::array<cv::Mat, kPictures> pictures;  ///< ring
  std::array<std::vector<cv::Point2f>, kPictures> corners;
  std::size_t newest = 0;
  std::size_t stored = 0;
  std::size_t age = 1;  ///< of the picture that this one is compared with
  cv::Mat evidence;     ///< CV_32FC1: positive where something else moves, negative where background
  cv::Mat instant;      ///< CV_32FC1: what this picture alone says, -1, 0 or 1
  FixedVector<MaskTrack, kTracks> tracks;
  FixedVector<cv::Matx33d, kLayers> layers;  ///< reference to this picture
  double noise = 2.0;                        ///< one sigma of a working pixel, levels

  // Scratch; contents mean nothing between calls.
  cv::Mat warped, seen, low, high, excess, excess_least, texture, corner_score;
};

/// Takes in a picture: reduces it, finds its corners, stores it.
void add_picture(const cv::Mat& gray, BackgroundState* state);

/// Compares the newest picture with an earlier one and adds to the evidence. The earlier picture is
/// the nearest in time that shows enough change. @param target known parts of the target
/// (CV_8UC1 of the working size, or empty): their points are no background.
/// @return false when no motion of a background was found; the evidence stays as it was.
bool compare_pictures(const cv::Mat& target, BackgroundState* state);

void clear(BackgroundState* state);

}  // namespace polhode
