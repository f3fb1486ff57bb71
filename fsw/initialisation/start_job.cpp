#include "initialisation/start_job.hpp"

#include <span>

namespace polhode {

void run_start(StartJob* job) {
  job->outcome = select_hypothesis({.times_s = std::span(job->times_s).first(job->frame_count),
                                    .tracks = std::span(job->tracks).first(job->track_count),
                                    .seed = job->seed},
                                   job->options,
                                   job->workspace);
}

void skip_start(StartJob* job) {
  job->outcome.decision = StartDecision::kTooFewTracks;
  job->outcome.crowded = false;
}

}  // namespace polhode
