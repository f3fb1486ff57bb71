// Fits a sine with an offset to samples of one quantity.
#pragma once

#include <span>

#include "base/result.hpp"

namespace polhode {

/// offset + amplitude sin(2 pi (t - t0) / period + phase), t0 the first sample's time.
struct SineFit {
  double offset = 0.0;
  double amplitude = 0.0;  ///< >= 0
  double period_s = 0.0;
  double phase_rad = 0.0;
  double sigma_offset = 0.0;
  double sigma_amplitude = 0.0;
  double sigma_period_s = 0.0;
  double sigma_phase_rad = 0.0;
  double rms = 0.0;       ///< of the residuals
  bool observed = false;  ///< the samples span a period, and the amplitude is significant;
                          ///< otherwise the numbers are meaningless
};

struct SineSample {
  double time_s = 0.0;
  double value = 0.0;
  double sigma = 1.0;       ///< of the value, > 0
  double interval_s = 0.0;  ///< the value is a mean over this time around time_s; the attenuation
                            ///< of the sine is corrected
};

/// Least squares. The period is searched on a grid, from two samples to twice the span, and
/// refined. Successive samples are differences of the same poses: where their intervals touch,
/// their noise is correlated by -1/2, so a slow sine is more accurate than with white noise. Sigmas
/// are scaled up where the residuals are larger.
/// @errors TooFewObservations (under 8 samples), Degenerate (no time passes, or a sigma is not
/// positive).
/// @cost   at most 4000 grid points times the samples.
Result<SineFit> fit_sine(std::span<const SineSample> samples);

}  // namespace polhode
