// The second core: runs a component's jobs on a thread of its own, and hands each back to the step
// that it names.
#pragma once

#include <pthread.h>

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

struct WorkerOptions {
  bool own_thread = true;  ///< false: a job runs on the caller's thread, at once
  std::size_t stack_bytes = std::size_t{2} << 20;  ///< the solvers take under 1 MB of it
  int core = 1;  ///< that the thread is bound to where the machine has it
  /// Real-time priority (SCHED_FIFO) of the thread where the machine grants it; 0: an ordinary one.
  /// Under that of the steps' thread, which comes first where both want one core.
  int priority = 0;
  /// For tests: each job is held back by a random time up to this.
  std::uint32_t latency_ms_max = 0;
  /// A job is only begun when its pool has this much in one piece: libraries do not survive
  /// without.
  std::size_t job_bytes = 0;
};

/// Which of its requests the thread was granted.
struct WorkerState {
  bool own_thread = false;
  bool bound_to_core = false;
  bool real_time = false;
};

/// One job at a time, in the order in which they come; as many may be out as a component has. The
/// thread lives as long as the worker.
class Worker {
 public:
  /// @throws RunFailure when the thread cannot be made.
  explicit Worker(const WorkerOptions& options);
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  Worker(Worker&&) = delete;
  Worker& operator=(Worker&&) = delete;

  using Duration = std::chrono::steady_clock::duration;
  using Durations = FixedVector<Duration, Jobs::capacity()>;

  /// Takes a step's jobs.
  void submit(const Jobs& jobs);

  /// Is a job that names this step not done yet? In flight the frame is then dropped, and counted.
  [[nodiscard]] bool late_for(std::uint32_t step);

  /// The jobs that name this step, run to their end: waits for them.
  Jobs due(std::uint32_t step);

  /// Waits for unfinished jobs; no job is then the worker's.
  void finish();

  [[nodiscard]] const WorkerState& state() const { return state_; }
  /// How long each of the jobs took that due() has handed back last.
  [[nodiscard]] const Durations& last_durations() const { return durations_; }

 private:
  /// A job that was submitted and not yet handed back.
  struct Entry {
    Job* job = nullptr;
    bool done = false;
    Duration duration{};
  };

  static void* thread_main(void* worker);
  void serve();
  [[nodiscard]] bool admitted() const;
  /// The first job that is not done; nullptr when all are.
  [[nodiscard]] Entry* next();
  Duration run(Job* job);
  void start_thread();
  void wait_until_done(const Job* job);

  WorkerOptions options_;
  WorkerState state_;
  pthread_t thread_{};
  pthread_mutex_t mutex_{};
  pthread_cond_t changed_{};
  FixedVector<Entry, Jobs::capacity()>
      entries_;  ///< in order of their coming; slots move under the lock only
  bool stop_ = false;
  std::uint32_t runs_ = 0;
  Durations durations_;
};

/// Cores that this process may use.
int cores_available();

}  // namespace polhode::platform
