#include "shape/shape_job.hpp"

namespace polhode {

bool shape_is_due(const ShapeState& state,
                  const Map& map,
                  std::uint32_t frame,
                  std::uint32_t every_frames) {
  return map.next_keyframe_number != state.keyframe_asked &&
         (!state.asked || frame - state.frame_asked >= every_frames);
}

void prepare_shape(const Map& map,
                   const ShapeOptions& options,
                   std::uint64_t seed,
                   std::uint32_t frame,
                   ShapeState* state,
                   ShapeJob* job) {
  job->landmarks_T.clear();
  for (const Landmark& landmark : map.landmarks) {
    if (landmark.used && confirmed(landmark)) {
      (void)job->landmarks_T.push_back(landmark.p_T);
    }
  }
  job->options = options;
  job->seed = seed;
  job->previous = state->shape;
  job->outcome.reset();
  state->asked = true;
  state->frame_asked = frame;
  state->keyframe_asked = map.next_keyframe_number;
}

void run_shape(ShapeJob* job) {
  const Result<Shape> shape = estimate_shape(job->landmarks_T.view(),
                                             job->options,
                                             job->seed,
                                             job->previous ? &*job->previous : nullptr,
                                             job->work);
  if (shape) {
    job->outcome = shape.value();
  }
}

void ask_shape_again(ShapeState* state) { state->keyframe_asked = 0; }

bool take_shape(const ShapeJob& job, std::uint32_t frame, ShapeState* state) {
  const std::optional<Shape>& before = state->shape;
  const Shape& now = *job.outcome;
  const bool same =
      before && before->planes.size() == now.planes.size() && before->completion == now.completion;
  state->shape = job.outcome;
  state->frame_of_estimate = frame;
  state->is_new = true;
  return !same;
}

}  // namespace polhode
