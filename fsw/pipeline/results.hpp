// Results of jobs come in, at the step that was named when they were issued.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Takes the results in whose step has come; may issue the next jobs.
void take_due_jobs(const Jobs& finished, Component::State* state);

/// Runs a job here that is to be done within the step, and those of its kind that follow from it.
/// Else nothing.
void run_undelayed(Job* job, Component::State* state);

/// At the end of a run: what is still out is run, unless that is done, and taken in.
void close_jobs(Component::State* state);

}  // namespace polhode
