// The second core: runs a component's jobs on a thread of its own, and hands each back to the step
// that it names.
#pragma once

#include <pthread.h>

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "pipeline/component.hpp"

namespace polhode::platform {

struct WorkerOptions {
  bool own_thread = true;  ///< false: a job is run where it is asked for, on the caller's thread
  std::size_t stack_octets = std::size_t{4} << 20;  ///< the solvers take under 1 MB of it
  int core = 1;  ///< that the thread is bound to where the machine has it
  /// For tests: each job is held back by a random time up to this.
  std::uint32_t latency_ms_max = 0;
  /// A job is only begun when its pool has this much in one piece: libraries do not survive without.
  std::size_t job_octets = 0;
};

/// What the thread got of what it asked for.
struct WorkerState {
  bool own_thread = false;
  bool bound_to_core = false;
};

/// One job at a time. The thread lives as long as the worker.
class Worker {
 public:
  /// @throws RunFailure when the thread cannot be made.
  explicit Worker(const WorkerOptions& options);
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  Worker(Worker&&) = delete;
  Worker& operator=(Worker&&) = delete;

  /// Takes a step's job; nullptr is no job.
  void submit(Job* job);

  /// Is the job that names this step still running? In flight the frame is then dropped, and counted.
  [[nodiscard]] bool late_for(std::uint32_t step);

  /// The job that names this step, run to its end: waits for it. nullptr when there is none.
  Job* due(std::uint32_t step);

  /// Waits for a job that is still running; it is then no longer the worker's.
  void finish();

  [[nodiscard]] const WorkerState& state() const { return state_; }
  /// How long the job took that was handed back last.
  [[nodiscard]] std::chrono::steady_clock::duration last_duration() const { return duration_; }

 private:
  static void* thread_main(void* worker);
  void serve();
  [[nodiscard]] bool admitted() const;
  void run(Job* job);
  void start_thread();
  void wait_until_done();

  WorkerOptions options_;
  WorkerState state_;
  pthread_t thread_{};
  pthread_mutex_t mutex_{};
  pthread_cond_t changed_{};
  Job* job_ = nullptr;  ///< submitted and not yet handed back
  bool running_ = false;
  bool stop_ = false;
  std::uint32_t runs_ = 0;
  std::chrono::steady_clock::duration duration_{};
};

/// Cores that this process may use.
int cores_available();

}  // namespace polhode::platform
