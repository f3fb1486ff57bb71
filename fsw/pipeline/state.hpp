// Everything that a component remembers from step to step. Visible, plain, owned by whoever owns
// the memory.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/time_doubt.hpp"
#include "bus/shape_telemetry.hpp"
#include "config/limits.hpp"
#include "features/detect.hpp"
#include "features/workspace.hpp"
#include "image/arrival.hpp"
#include "image/image.hpp"
#include "image/quality.hpp"
#include "initialisation/collect.hpp"
#include "map/drift.hpp"
#include "map/follow.hpp"
#include "map/landmarks.hpp"
#include "map/localise.hpp"
#include "map/map.hpp"
#include "mask/follow.hpp"
#include "mask/target_mask.hpp"
#include "motion/estimator.hpp"
#include "motion/prediction_walk.hpp"
#include "pipeline/bus_state.hpp"
#include "pipeline/component.hpp"
#include "pipeline/job_types.hpp"
#include "shape/scale_state.hpp"
#include "shape/shape_state.hpp"

namespace polhode {

/// Predictions under way to the bus, and what the frame that they start from had.
struct AheadNow {
  PredictionWalk walk;
  std::int64_t timestamp_ns = 0;
  std::uint32_t frame = 0;
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();
};

struct Component::State {
  Parameters parameters;
  CameraModel camera;
  Counters counters;
  Mode mode = Mode::kIdle;
  StageHook hook = nullptr;
  void* hook_context = nullptr;

  // This frame.
  std::uint32_t frame = 0;  ///< index; no command resets it
  std::uint32_t next_frame = 0;
  std::int64_t timestamp_ns = 0;  ///< of the last frame whose picture could be looked at
  bool time_known = false;
  TimeDoubt time_doubt;
  cv::Mat gray;
  QualityHistory quality;
  ArrivalHistory arrivals;
  FrameVerdict verdict;
  TargetMask mask;
  MaskState mask_state;
  FixedVector<cv::Point2f, limits::kLandmarks> prior_points_px;
  Features features;
  bool features_ready = false;
  Pyramid pyramid;
  LocalisedFrame localised;
  bool pose_valid = false;
  std::uint32_t steps_to_shed = 0;  ///< for so long less is asked of the libraries

  InitialisationState initialisation;  ///< before the map

  // The map and what follows from it.
  Map map;
  FlowReference reference;
  std::uint32_t reference_frame = 0;  ///< that it was taken from
  MapDrift drift;
  std::uint32_t target_frame =
      0;  ///< number of the frame T that the map is in: poses of two do not compare
  MotionEstimate motion;
  AheadNow ahead;
  ShapeState shape;
  ScaleState scale;
  double noise_scale = 1.0;  ///< how much larger the residuals are than the features' sigma says
  LastAdjustment last_adjustment_of_all;
  double map_moved_rad = 0.0;  ///< in this step, by an adjustment that frames have come since

  // The long work that is out, or that has just come back.
  MapJob job;
  FitJob fit_job;
  ShapeJob shape_job;
  GrowthWaiting growth;

  // Working memory of single calls.
  FeatureWorkspace feature_workspace;
  LocaliseScratch localise_scratch;
  CreateScratch create_scratch;
  LocalisedFrame closure;

  // Output.
  BusState bus;
  std::array<double, 4> q_CT_last{1.0, 0.0, 0.0, 0.0};
  FixedVector<Observation, limits::kPoseMatches> observations;
  StepOutput output;
};

/// 1-sigma of a metre, and of the map's unit while the start is all it stands on, as a part of it.
inline double length_sigma(const Component::State& s) {
  return std::hypot(s.scale.relative_sigma, unit_sigma(s.drift));
}

/// As the bus's packets take it.
inline bus::LengthUnit length_unit(const Component::State& s) {
  return {.known = s.scale.known,
          .metres_per_mu = s.scale.metres_per_mu,
          .relative_sigma = length_sigma(s)};
}

}  // namespace polhode
