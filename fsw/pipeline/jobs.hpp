// The long work, apart from the step: plain snapshots that a pure function turns into results, on
// whichever thread the caller likes.
//
// One job of the map, one fit of the dynamics and one estimate of the shape are out at a time; none
// waits for another, as the last two change nothing of the map. A result is taken in at a step that
// is named when the job is issued (logical execution time), so the packets do not depend on how
// long the work took.
#pragma once

#include "pipeline/job_types.hpp"

namespace polhode {

/// Sends off what has been prepared in `state->job`: to the caller with this step's output, or,
/// with a delay of 0, to run_undelayed() of results.hpp.
void issue_job(JobKind kind, Component::State* state);

/// As issue_job, of `state->fit_job`.
void issue_fit(Component::State* state);

/// As issue_job, of `state->shape_job`.
void issue_shape(Component::State* state);

/// No job of the map is out: a new one may be prepared.
[[nodiscard]] bool job_slot_free(const Component::State& state);
[[nodiscard]] bool fit_slot_free(const Component::State& state);
[[nodiscard]] bool shape_slot_free(const Component::State& state);

/// A contest that is out is for frames that are no longer there.
void give_up_start(Component::State* state);

/// What is out belongs to a target that is forgotten.
void forget_jobs(Component::State* state);

/// The jobs that this step has issued for the caller to run.
[[nodiscard]] Jobs jobs_for_caller(Component::State* state);

}  // namespace polhode
