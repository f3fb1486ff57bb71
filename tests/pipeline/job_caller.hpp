// What a caller does with a component's jobs, in its long form, and a body that gives it some.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "base/rng.hpp"
#include "bench.hpp"
#include "geometry/so3.hpp"
#include "state_of.hpp"

namespace polhode::bench {

/// Every job so many frames later; none leaves its step with 0.
inline JobOptions delayed(int frames) {
  return {.delay_frames = frames, .delay_of_all_frames = frames};
}

/// When the caller gets round to running a job: the packets must not show it.
enum class Run : std::uint8_t { kAtOnce, kWhenDue, kAtRandom };

class Caller {
 public:
  Caller(Parameters p, JobOptions jobs, Run run) : run_(run), bench_(with_jobs(p, jobs)) {}

  const StepOutput& show(const Picture& picture,
                         std::span<const std::span<const std::uint8_t>> commands = {}) {
    Jobs finished;
    for (std::size_t i = 0; i < out_.size();) {
      const bool due = due_step(*out_[i]) == component().next_step();
      if (!out_[i]->done && (due || (run_ == Run::kAtRandom && chance_.below(2) == 0))) {
        run_job(*out_[i]);
      }
      if (due) {
        (void)finished.push_back(out_[i]);
        out_.erase(i);
      } else {
        ++i;
      }
    }
    const StepOutput& out = component().step(
        {.frame = frame_of(state().clock.timestamp_ns + Bench::kSecond_ns, picture),
         .finished = finished,
         .commands = commands});
    for (Job* job : out.jobs) {
      EXPECT_TRUE(out_.push_back(job)) << "more jobs at a time than promised";
      ++jobs_;
      fits_ += is_out_with<FitJob>(*job) ? 1 : 0;
      if (run_ == Run::kAtOnce) {
        run_job(*job);
      }
    }
    packets_.insert(packets_.end(), out.packets.begin(), out.packets.end());
    return out;
  }

  [[nodiscard]] int jobs() const { return jobs_; }
  [[nodiscard]] int fits() const { return fits_; }
  /// The job of that kind that is out; nullptr when none is.
  template <typename Work>
  [[nodiscard]] const Job* out() const {
    for (const Job* job : out_) {
      if (is_out_with<Work>(*job)) {
        return job;
      }
    }
    return nullptr;
  }
  [[nodiscard]] const Job* map_job_out() const {
    const Job* start = out<InitialisationJob>();
    return start != nullptr ? start : out<AdjustmentJob>();
  }
  [[nodiscard]] Component& component() { return *bench_.component; }
  [[nodiscard]] const Component::State& state() { return state_of(*bench_.component); }
  [[nodiscard]] const std::vector<std::uint8_t>& packets() const { return packets_; }

 private:
  static Parameters with_jobs(Parameters p, JobOptions jobs) {
    p.jobs = jobs;
    return p;
  }
  Run run_;
  Bench bench_;
  Rng chance_{7, 8};
  int jobs_ = 0;
  int fits_ = 0;
  Jobs out_;
  std::vector<std::uint8_t> packets_;
};

/// A ball that turns by 3 deg a frame.
inline const std::vector<Picture>& turning_ball() {
  static const std::vector<Picture> pictures = [] {
    const Ball ball(61);
    std::vector<Picture> made;
    for (int i = 0; i < 32; ++i) {
      const Eigen::Matrix3d R_CT = so3_exp(Eigen::Vector3d(0.012, 0.052, 0.005) * i);
      made.push_back(ball.seen_from({.R_CT = R_CT, .p_CT = {0.0, 0.0, 6.0}}));
    }
    return made;
  }();
  return pictures;
}

/// After all of turning_ball(); made once for each way of running it.
inline Caller& shown(JobOptions jobs, Run run) {
  static std::map<std::tuple<int, int, Run>, std::unique_ptr<Caller>> made;
  std::unique_ptr<Caller>& caller = made[{jobs.delay_frames, jobs.delay_of_all_frames, run}];
  if (caller == nullptr) {
    caller = std::make_unique<Caller>(parameters(), jobs, run);
    for (const Picture& picture : turning_ball()) {
      (void)caller->show(picture);
    }
  }
  return *caller;
}

}  // namespace polhode::bench
