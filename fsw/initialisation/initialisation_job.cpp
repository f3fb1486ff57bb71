#include "initialisation/initialisation_job.hpp"

#include <span>

namespace polhode {

void run_initialisation(InitialisationJob* job) {
  const std::span tracks = std::span(job->tracks).first(job->track_count);
  align_tracks(job->images, job->frame_count, tracks, &job->alignment);
  job->outcome = select_hypothesis({.times_s = std::span(job->times_s).first(job->frame_count),
                                    .R_IC = std::span(job->R_IC).first(job->frame_count),
                                    .tracks = tracks,
                                    .seed = job->seed},
                                   job->options,
                                   &job->workspace);
}

void skip_initialisation(InitialisationJob* job) {
  job->outcome.decision = InitialDecision::kTooFewTracks;
  job->outcome.crowded = false;
}

}  // namespace polhode
