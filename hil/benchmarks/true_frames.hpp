// The frames of a sequence with truth, in memory, for the benchmarks.
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "features/match.hpp"
#include "geometry/camera_model.hpp"
#include "geometry/pose.hpp"

namespace polhode::benchmark {

/// A sequence's truth.csv: the pose by time stamp.
std::map<std::int64_t, Pose> read_truth(const std::string& file);

/// Frames that can be read and whose pose is known, both in order of time.
struct TrueFrames {
  CameraModel camera;
  std::vector<cv::Mat> gray;
  std::vector<Pose> pose;
};

/// @param folder with mav0 and truth.csv. @throws what platform::open_sequence throws.
TrueFrames read_true_frames(const std::string& folder);

/// A match this near to the true epipolar line counts as right.
inline constexpr double kRight_px = 1.5;

/// Matches of the features of two frames, and how far each right one is from the true epipolar
/// line.
struct JudgedMatches {
  int matches = 0;
  std::vector<double> off_px;  ///< of the right ones
};

JudgedMatches match_frames(const TrueFrames& frames,
                           std::size_t a,
                           std::size_t b,
                           const Features& of_a,
                           const Features& of_b);

}  // namespace polhode::benchmark
