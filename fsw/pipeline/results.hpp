// Takes results of jobs, at the step that was fixed when they were issued.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Takes the results that are due in this step; may issue the next jobs.
void take_due_jobs(const Jobs& finished, Component::State* state);

/// Runs a job that is due within this step, and follow-up jobs of its kind. Otherwise does nothing.
void run_undelayed(Job* job, Component::State* state);

/// At the end of a run: runs the jobs still out, unless done already, and takes their results.
void close_jobs(Component::State* state);

}  // namespace polhode
