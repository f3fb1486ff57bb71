#pragma once

// One line an option:
// clang-format off
namespace polhode {

struct FeatureOptions {
  int count_max = 800;             ///< features kept per frame, 50 .. limits::kFeatures
  double gamma = 1.8;              ///< gray levels to this power are taken for light, 1 .. 3; 1: of a linear camera
  double contrast_min = 0.003;     ///< least blob contrast (SIFT) in light, fraction of full scale, 0.001 .. 0.2
  int working_pixels_max = 580000; ///< region of interest is resampled to this many pixels before detection, 10000 .. limits::kWorkingPixels
  double sigma_px = 0.25;          ///< 1-sigma of a feature's position at the finest scale, 0.05 .. 5
};

}  // namespace polhode
