// Measures the quality of a frame. The verdict: use; degraded frame, pose only; or skip.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "base/fixed_vector.hpp"
#include "image/options.hpp"
#include "image/verdict.hpp"

namespace polhode {

/// Measured in one image alone.
struct ImageLevels {
  double bright_level = 0.0;  ///< reached by 0.1 % of the pixels or 400, fraction of full scale
  double dim_level = 0.0;     ///< level that 99.9 % of the pixels exceed, fraction of full scale
  double mean_level = 0.0;    ///< fraction of full scale
  double saturated_fraction = 0.0;  ///< pixels at or over the saturated level
  double lit_fraction = 0.0;        ///< pixels over the dark level
  double sharpness = 0.0;  ///< mean change over 1 px by that over 4 px, of lit pixels; 0: no
                           ///< contrast, 1: white noise
  bool dark = false;       ///< no pixel is bright
};

/// Traces of bit errors, of one image alone. Scenes have some of the first two kinds.
struct BitErrorTraces {
  double pixels = 0.0;            ///< of the image
  double impulse_fraction = 0.0;  ///< share of outlier pixels: only a flip of the highest bit
                                  ///< differs so far from eight neighbours that agree
  int rough_tiles = 0;  ///< tiles of 16 x 16 px as rough as random bytes, where the last good frame
                        ///< was smooth nearby
  int lines = 0;        ///< rows that differ from both neighbours, which agree, for the first time:
                        ///< a crosshair stays in place
};

/// Rows that are the previous frame's, byte for byte. A row in which fewer than 32 pixels differ
/// from the first is blank and not counted. Blank rows count as repeated where they had another
/// level in the last good frame, if at least an eighth of the image is such, but not all of it. So
/// the rest of a white or a black frame is recognised in the next one.
struct RepeatedRows {
  int repeated = 0;
  int fresh = 0;
  int changes = 0;  ///< between runs of repeated and of fresh rows
};

/// All measurements of a frame.
struct ImageQuality {
  ImageLevels levels;
  BitErrorTraces bit_errors;
  RepeatedRows rows;
};

/// The last frames, for comparison. Owned by the caller; memory is taken with the first frame.
struct QualityHistory {
  // Decision 0001. Chosen: medians are right with up to seven untypical frames. Larger follows
  // changes of light later, smaller has less certain spreads.
  static constexpr std::size_t kFrames = 15;
  /// Numbers of a good frame.
  struct Entry {
    double bright_level = 0.0;
    double mean_level = 0.0;
    double saturated_fraction = 0.0;
    double lit_fraction = 0.0;
    double sharpness = 0.0;
    double impulse_fraction = 0.0;
    double rough_tiles = 0.0;
    double lines = 0.0;
  };
  cv::Mat previous;        ///< as delivered, good or bad
  cv::Mat roughness;       ///< CV_8UC1 by tile, of this image: mean change from pixel to pixel
  cv::Mat roughness_good;  ///< of the last good frame, the largest of 5 x 5 tiles; empty before
  cv::Mat lines_known;  ///< CV_8UC1, a row each: number of frames for which a broken line is still
                        ///< remembered; empty before
  cv::Mat
      row_levels_good;  ///< CV_8UC1, a row each: mean level in the last good frame; empty before
  FixedVector<Entry, kFrames> frames;  ///< the last good ones, oldest first
  /// Per fault: plus one with each frame that shows it, minus one with each other.
  std::array<int, kFrameFaults> persistence{};
};

/// One pass over the image. Above half a million pixels, only over enough rows for that many.
ImageLevels measure_levels(const cv::Mat& gray, const ImageOptions& options);

/// Two passes over the image.
/// @param history gives the last good frame's roughness and the last frames' lines, if any, and
///                takes this one's.
BitErrorTraces find_bit_errors(const cv::Mat& gray, QualityHistory* history);

/// @param history its previous frame is none, or of the same size.
RepeatedRows compare_rows(const cv::Mat& gray,
                          const ImageOptions& options,
                          const QualityHistory& history);

/// Stores a good frame's row levels, by which compare_rows recognises blank rows.
void remember_rows(const cv::Mat& gray, QualityHistory* history);

/// As if no frame had been seen.
void clear(QualityHistory* history);

/// The verdict on a frame, by itself and by the last good frames. A fault that persists (seen in
/// most of the last frames) is a property of the scene or the camera. Such a frame is a degraded
/// frame, pose only, and becomes part of the history. Dark, flat and frozen frames are never used.
FrameVerdict assess_quality(const ImageQuality& quality,
                            const ImageOptions& options,
                            QualityHistory* history);

/// Measures a frame, decides on it, and adds it to the history.
FrameVerdict assess(const cv::Mat& gray, const ImageOptions& options, QualityHistory* history);

}  // namespace polhode
