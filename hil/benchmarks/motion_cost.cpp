// What the causal fit of the dynamics costs a frame, over a long run: bench_motion_cost [FRAMES].
//
// Poses of free bodies come one by one, are remembered in the bounded table and fitted when a fit
// is due, as a run's second thread does it. A row for each tenth of the frames: processor time a
// frame, spread over all of them.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "free_body.hpp"
#include "motion/fit_poses.hpp"
#include "motion/rigid_model.hpp"
#include "os/linux/clock.hpp"

namespace {

double processor_s() {
  return 1e-9 * static_cast<double>(polhode::platform::clock_ns(CLOCK_THREAD_CPUTIME_ID));
}

struct LongRun {
  std::unique_ptr<polhode::MotionSnapshot> snapshot = std::make_unique<polhode::MotionSnapshot>();
  std::unique_ptr<polhode::MotionWorkspace> workspace =
      std::make_unique<polhode::MotionWorkspace>();
  polhode::RigidModel model;
  std::size_t since_fit = 0;
  int fits = 0;
  double longest_s = 0.0;
};

/// Takes one pose in. @return processor time that its fit took, 0 where none was due
double take(const polhode::PoseSample& sample, LongRun* run) {
  (void)polhode::remember_for_fit(run->snapshot->poses, sample, run->snapshot->options);
  ++run->since_fit;
  if (!polhode::fit_is_due(run->model, run->snapshot->poses.size(), run->since_fit)) {
    return 0.0;
  }
  const double begin_s = processor_s();
  run->snapshot->previous = run->model;
  run->model = polhode::fit_rigid_model(*run->snapshot, *run->workspace);
  run->since_fit = 0;
  ++run->fits;
  const double took_s = processor_s() - begin_s;
  run->longest_s = std::max(run->longest_s, took_s);
  return took_s;
}

void report(const char* name,
            const polhode::FreeBody& body,
            std::size_t frames,
            double interval_s) {
  const auto samples = polhode::observed(polhode::tumble(body, frames, interval_s), {}, 1);
  LongRun run;
  run.snapshot->body_radius = 1.0;
  std::printf("%s, %zu frames of %g s: ms a frame by tenths", name, frames, interval_s);
  for (int tenth = 0; tenth < 10; ++tenth) {
    const std::size_t from = frames * static_cast<std::size_t>(tenth) / 10;
    const std::size_t to = frames * static_cast<std::size_t>(tenth + 1) / 10;
    double spent_s = 0.0;
    for (std::size_t i = from; i < to; ++i) {
      spent_s += take(samples[i], &run);
    }
    std::printf(" %.2f", 1e3 * spent_s / static_cast<double>(to - from));
    std::fflush(stdout);
  }
  std::printf("\n  %d fits, the longest %.0f ms; %s, poses %zu\n",
              run.fits,
              1e3 * run.longest_s,
              run.model.accepted() ? "accepted" : "not accepted",
              static_cast<std::size_t>(run.model.poses));
}

}  // namespace

int main(int argc, char** argv) {
  const auto frames =
      static_cast<std::size_t>(std::max(10, argc > 1 ? std::atoi(argv[1]) : 10'000));
  report("paper's body", polhode::paper_body(), frames, 10.0);
  report("tumble", polhode::asymmetric_body(3.0 * polhode::kDegree_rad), frames, 2.0);
  report("fast tumble at 10 Hz", polhode::asymmetric_body(5.0 * polhode::kDegree_rad), frames, 0.1);
  return 0;
}
