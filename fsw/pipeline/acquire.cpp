#include "pipeline/acquire.hpp"

#include "mask/follow.hpp"
#include "pipeline/state.hpp"

namespace polhode {

void collect(Component::State* s) {
  PictureState& picture = s->picture;
  // What is not told apart from its background may be the background: maps of clouds were begun.
  if (is_out(s->jobs.map) || picture.verdict.decision != FrameDecision::kUse ||
      may_be_background(picture.mask_state)) {
    return;
  }
  // Where a known aspect has been looked for in vain features are there already, from a mask that
  // was not cut; the outline goes along.
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
    // No job is out, so nobody reads them.
    keep_crop(
        picture.gray, s->clock.frame, s->features.features.view(), &s->jobs.start.images.crops);
  }
  // A target that is known by a model is given ten frames of it to be recognised: T is then the
  // model's.
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
