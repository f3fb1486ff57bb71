#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// Ranges and units are in pipeline/parameter_table.cpp.
// clang-format off
namespace polhode {

struct FeatureOptions {
  // Under limits::kFeatures, whose comment has the reason.
  int count_max = 800;             ///< features kept per frame at most
  // decision 0022: 2.2, the gamma of the scenes, loses dark faces.
  double gamma = 1.8;              ///< gray level to this power is taken as light; 1: linear camera
  // 0.77 of 255 levels. Chosen; smaller: more and weaker features.
  double contrast_min = 0.003;     ///< least blob contrast (SIFT) in light, fraction of full scale
  // As fine as OpenCV's SIFT on 260,000 pixels: 2^2 times as many, and 0.75^2 of those (decision 0021).
  int working_pixels_max = 580000; ///< the target's region is resampled to this many pixels at most
  // decision 0024: most positions are good to 0.14 to 0.2 px, with heavy tails.
  double sigma_px = 0.25;          ///< 1-sigma of a feature's image position at the finest scale
};

}  // namespace polhode
