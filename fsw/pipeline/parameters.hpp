// All parameters in one plain table: defaults work on any sequence, units are in the names.
#pragma once

#include <cstdint>
#include <optional>

#include "base/result.hpp"
#include "bus/options.hpp"
#include "features/options.hpp"
#include "image/options.hpp"
#include "initialisation/options.hpp"
#include "map/options.hpp"
#include "mask/options.hpp"
#include "motion/options.hpp"
#include "pipeline/options.hpp"
#include "shape/options.hpp"
#include "tracks/options.hpp"

namespace polhode {

/// Pinhole with radial-tangential distortion; the top-left pixel's centre is (0, 0).
struct CameraParameters {
  int width_px = 0;
  int height_px = 0;
  double fu_px = 0.0;
  double fv_px = 0.0;
  double cu_px = 0.0;
  double cv_px = 0.0;
  double k1 = 0.0;
  double k2 = 0.0;
  double p1 = 0.0;
  double p2 = 0.0;
  double line_time_ns = 0.0;  ///< from one row to the next below it; 0: a global shutter
};

struct CameraModel;  // geometry/camera_model.hpp
CameraModel to_model(const CameraParameters& camera);

struct Parameters {
  CameraParameters camera;
  ImageOptions image;
  MaskOptions mask;
  FeatureOptions features;
  TrackOptions tracks;
  InitialOptions start;
  LocaliseOptions localise;
  MapOptions map;
  ShapeOptions shape;
  ScaleOptions scale;
  MotionOptions motion;
  BusOptions bus;
  JobOptions jobs;
  BudgetOptions budget;
  std::uint64_t seed = 1;  ///< of every random draw
};

/// @return nothing when all is in range, else the first problem: field, value, allowed range.
std::optional<Error> check(const Parameters& parameters);

}  // namespace polhode
