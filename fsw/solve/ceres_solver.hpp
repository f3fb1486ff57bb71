// Options that all uses of Ceres share.
#pragma once

#include <ceres/problem.h>
#include <ceres/solver.h>

#include "solve/bundle_problem.hpp"

namespace polhode {

/// Nothing is owned by the problem: cost functions and losses are the caller's.
/// @param callback  called before each evaluation.
ceres::Problem::Options problem_options(ceres::EvaluationCallback* callback);

/// One thread, no limit of time, no messages: the same problem gives the same bytes.
ceres::Solver::Options solver_options(int iterations_max);

BundleReport report_of(const ceres::Solver::Summary& summary);

}  // namespace polhode
