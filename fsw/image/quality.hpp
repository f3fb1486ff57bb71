// What can be wrong with a frame, measured, and what follows from it: use, use with care, or skip.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "base/fixed_vector.hpp"
#include "image/options.hpp"
#include "image/verdict.hpp"

namespace polhode {

/// Of one picture alone.
struct ImageLevels {
  double bright_level =
      0.0;  ///< level that 0.1 % of the pixels, or 400 of them, reach, fraction of full scale
  double dim_level = 0.0;   ///< level that 99.9 % of the pixels exceed, fraction of full scale
  double mean_level = 0.0;  ///< fraction of full scale
  double saturated_fraction = 0.0;  ///< pixels at or over the saturated level
  double lit_fraction = 0.0;        ///< pixels over the dark level
  double sharpness =
      0.0;  ///< mean change over 1 px by mean change over 4 px, lit pixels; 0: none, 1: white noise
  bool dark = false;  ///< nothing to see
};

/// Traces of bit errors, of one picture alone. Scenes have some of the first two kinds.
struct BitErrorTraces {
  double pixels = 0.0;            ///< of the picture
  double impulse_fraction = 0.0;  ///< pixels that stand out from eight neighbours that agree, by
                                  ///< more than any but the highest bit
  int rough_tiles = 0;  ///< tiles of 16 x 16 px that change from pixel to pixel like random octets,
                        ///< where the last good picture had nothing like it nearby
  int lines = 0;        ///< rows that differ from both neighbours, which agree
};

/// Rows that are the previous frame's, octet for octet. A row with fewer than 32 pixels that differ
/// from its first tells nothing and is not counted, unless an eighth of the picture, and not all of
/// it, has become such rows since the last good one: so the rest of a white or a black frame is
/// known in the one after it.
struct RepeatedRows {
  int repeated = 0;
  int fresh = 0;
  int changes = 0;  ///< between runs of repeated and of fresh rows
};

/// Everything measured of a frame.
struct ImageQuality {
  ImageLevels levels;
  BitErrorTraces bit_errors;
  RepeatedRows rows;
};

/// What a frame is compared with. Owned by the caller; memory is taken with the first frame.
struct QualityHistory {
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
  cv::Mat roughness;       ///< CV_8UC1 by tile, of this picture: mean change from pixel to pixel
  cv::Mat roughness_good;  ///< of the last good picture, the largest of 5 x 5 tiles; empty before
  cv::Mat
      row_levels_good;  ///< CV_8UC1, a row each: mean level in the last good picture; empty before
  FixedVector<Entry, kFrames> frames;  ///< the last good ones, oldest first
  /// Per fault: up by one with each frame that shows it, down by one with each that does not.
  std::array<int, kFrameFaults> insistence{};
};

/// One pass over every row, of pictures over half a million pixels over as many rows as hold so
/// many.
ImageLevels measure_levels(const cv::Mat& gray, const ImageOptions& options);

/// Two passes over the picture.
/// @param history gives the last good picture's roughness, if any, and takes this one's.
BitErrorTraces find_bit_errors(const cv::Mat& gray, QualityHistory* history);

/// @param history its previous frame is none, or of the same size.
RepeatedRows compare_rows(const cv::Mat& gray,
                          const ImageOptions& options,
                          const QualityHistory& history);

/// Of a good picture: what compare_rows knows blank rows by.
void remember_rows(const cv::Mat& gray, QualityHistory* history);

/// As if no frame had been seen.
void clear(QualityHistory* history);

/// The verdict on a frame, by what it is and by what the last good frames were. What insists (a
/// fault seen in most of the last frames) is the scene or the camera, not an accident: such a frame
/// is used with care and becomes part of the history. Only darkness, flatness and frozen pictures
/// are never used.
FrameVerdict judge_quality(const ImageQuality& quality,
                           const ImageOptions& options,
                           QualityHistory* history);

/// Measures, judges, remembers.
FrameVerdict assess(const cv::Mat& gray, const ImageOptions& options, QualityHistory* history);

}  // namespace polhode
