#include "pipeline/state.hpp"

#include <algorithm>

#include "features/detect.hpp"
#include "features/row_times.hpp"

namespace polhode {

bool needs_more_memory(const Parameters& parameters, const Configuration& configuration) {
  const bool unplanned =
      parameters.mask.separates_background() && !configuration.background_planned;
  return unplanned || memory_needed(parameters).total > configuration.memory_octets;
}

MapInput map_input(const Component::State& s) {
  const Parameters& parameters = s.configuration.parameters;
  return {.frame = s.clock.frame,
          .timestamp_ns = s.clock.timestamp_ns,
          .R_IC = s.motion.R_IC,
          .gray = &s.picture.gray,
          .features = &s.features.features,
          .camera = &s.configuration.camera,
          .image_motion = s.features.image_motion,
          .localise = &parameters.localise,
          .tracks = &parameters.tracks,
          .options = &parameters.map,
          .features_max = static_cast<std::size_t>(parameters.features.count_max),
          .seed = parameters.seed};
}

ScaleInput scale_input(const Component::State& s) {
  return {.options = &s.configuration.parameters.scale, .camera = &s.configuration.camera};
}

JobTimes job_times(const Component::State& s) {
  const JobOptions& jobs = s.configuration.parameters.jobs;
  const auto window = static_cast<std::uint32_t>(jobs.delay_frames);
  return {.step = s.clock.frame,
          .delay = has_work_beside(jobs) ? std::max(1U, window) : 0U,
          .delay_of_window = window,
          .delay_of_all = std::max(window, static_cast<std::uint32_t>(jobs.delay_of_all_frames))};
}

void forget_frame(MapState* mapping, PictureState* picture, FeatureState* features) {
  begin_frame(mapping);
  picture->verdict = {};
  features->ready = false;
  features->image_motion = {};
  features->features.clear();
}

void detect_once(const PictureState& picture,
                 const Configuration& configuration,
                 bool memory_short,
                 const StageTimer& timer,
                 FeatureState* state) {
  if (state->ready) {
    return;
  }
  FeatureOptions options = configuration.parameters.features;
  if (memory_short) {                // half the pixels, and half the features
    constexpr int kCountLeast = 50;  // least configurable count
    options.working_pixels_max /= 2;
    options.count_max = std::max(kCountLeast, options.count_max / 2);
  }
  const CameraModel& camera = configuration.camera;
  Features* features = &state->features;
  detect_features({&picture.gray, &picture.mask}, camera, options, &state->workspace, features);
  to_frame_time(camera, state->image_motion, features);
  leave_out_resting(&state->resting, features);
  state->ready = true;
  stage_done(Stage::kFeatures, timer);
}

}  // namespace polhode
