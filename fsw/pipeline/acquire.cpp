#include "pipeline/acquire.hpp"

#include "pipeline/jobs.hpp"
#include "pipeline/picture.hpp"

namespace polhode {

void collect(Component::State* s) {
  if (!job_slot_free(*s) || s->verdict.decision != FrameDecision::kUse) {
    return;
  }
  // Where a known side has been looked for in vain features are there already, from a mask that was
  // not cut; the outline goes along.
  sharpen_outline(&s->mask_state);
  open_outline(s->gray.size(), &s->mask_state, &s->mask);
  stage_done(Stage::kMask, *s);
  ensure_features(s);
  const Collected collected = collect_frame({.frame = s->frame,
                                             .timestamp_ns = s->timestamp_ns,
                                             .R_IC = s->motion.R_IC,
                                             .features = &s->features},
                                            s->parameters.tracks.descriptor_ratio_max,
                                            &s->initialisation);
  s->counters.tables_full += collected.tables_full;
  if (!collected.kept ||
      static_cast<int>(s->initialisation.tracks.frames.size()) < s->parameters.start.frames_min) {
    return;
  }
  ++s->counters.start_contests;
  pose_problem(
      s->initialisation, s->camera, s->parameters.start, s->parameters.seed, &s->job.start);
  issue_job(JobKind::kStart, s);
}

}  // namespace polhode
