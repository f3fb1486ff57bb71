#include "solve/ceres_solver.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace polhode::ceres_solver_test {
namespace {

ceres::Solver::Summary summary_of(ceres::TerminationType termination, double final_cost) {
  ceres::Solver::Summary summary;
  summary.termination_type = termination;
  summary.initial_cost = 5.0;
  summary.final_cost = final_cost;
  summary.iterations.resize(4);  // the start and three steps
  return summary;
}

TEST(CeresSolver, ReportsWhatASolutionCosts) {
  for (const ceres::TerminationType termination : {ceres::CONVERGENCE, ceres::NO_CONVERGENCE}) {
    const BundleReport report = report_of(summary_of(termination, 2.0));
    EXPECT_TRUE(report.usable);
    EXPECT_EQ(report.iterations, 3);
    EXPECT_EQ(report.cost_before, 5.0);
    EXPECT_EQ(report.cost_after, 2.0);
  }
}

TEST(CeresSolver, ReportsNoGain_WhereASolutionCannotBeUsed) {
  const BundleReport failed = report_of(summary_of(ceres::FAILURE, 2.0));
  EXPECT_FALSE(failed.usable);
  EXPECT_EQ(failed.cost_after, 5.0);
  for (const double cost :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    const BundleReport report = report_of(summary_of(ceres::CONVERGENCE, cost));
    EXPECT_FALSE(report.usable);
    EXPECT_EQ(report.cost_after, 5.0);
  }
}

TEST(CeresSolver, LetsNeitherClockNorThreadsDecide) {
  const ceres::Solver::Options options = solver_options(7);
  EXPECT_EQ(options.max_num_iterations, 7);
  EXPECT_EQ(options.num_threads, 1);
  EXPECT_EQ(options.max_solver_time_in_seconds, ceres::Solver::Options{}.max_solver_time_in_seconds)
      << "which is some thirty years";
  std::string error;
  EXPECT_TRUE(options.IsValid(&error)) << error;
}

}  // namespace
}  // namespace polhode::ceres_solver_test
