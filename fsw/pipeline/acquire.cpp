#include "pipeline/acquire.hpp"

#include "mask/follow.hpp"
#include "pipeline/state.hpp"

namespace polhode {

void collect(Component::State* s) {
  PictureState& picture = s->picture;
  // A mask that is not separated from the background may be the background: clouds were mapped so.
  if (is_out(s->jobs.map) || picture.verdict.decision != FrameDecision::kUse ||
      may_be_background(picture.mask_state)) {
    return;
  }
  // After a failed relocalisation the frame already has features, from a mask without a graph cut.
  // The outline is sharpened all the same.
  sharpen_outline(&picture.mask_state);
  open_outline(picture.gray.size(), &picture.mask_state, &picture.mask);
  if (picture.own != nullptr) {
    close_cells(*picture.own, &picture.mask);
  }
  stage_done(Stage::kMask, s->timer);
  detect_once(s->picture, s->configuration, s->steps_to_shed > 0, s->timer, &s->features);
  const Parameters& parameters = s->configuration.parameters;
  const Collected collected = collect_frame({.frame = s->clock.frame,
                                             .timestamp_ns = s->clock.timestamp_ns,
                                             .R_IC = s->motion.R_IC,
                                             .features = &s->features.features},
                                            s->configuration.camera,
                                            parameters.tracks.descriptor_ratio_max,
                                            &s->initialisation,
                                            &s->features.resting);
  s->counters.tables_full += collected.tables_full;
  if (collected.kept) {
    // No map job is out, so no worker reads the crops.
    keep_crop(
        picture.gray, s->clock.frame, s->features.features.view(), &s->jobs.start.images.crops);
  }
  // A stored target model gets ten frames to be recognised, so that T stays the model's.
  constexpr std::uint32_t kFramesForModel = 10;
  const bool model_waits = s->mapping.map.keyframe_count > 0 && s->motion.recent.empty();
  if (model_waits && ++s->mapping.before.looked_for <= kFramesForModel) {
    return;
  }
  if (!collected.kept || !wants_selection(parameters.start, s->initialisation)) {
    return;
  }
  ++s->counters.start_contests;
  pose_problem(s->configuration.camera,
               parameters.start,
               parameters.seed,
               &s->initialisation,
               &s->jobs.start);
  issue_job(&s->jobs.start, job_times(*s), &s->jobs.map, &s->jobs);
}

}  // namespace polhode
