#include "os/linux/worker.hpp"

#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "base/assert.hpp"
#include "base/rng.hpp"
#include "errors.hpp"
#include "os/linux/memory/region.hpp"

namespace polhode::platform {
namespace {

using Clock = std::chrono::steady_clock;

/// Holds the mutex as long as it lives.
class Lock {
 public:
  explicit Lock(pthread_mutex_t& mutex) : mutex_(mutex) { pthread_mutex_lock(&mutex_); }
  ~Lock() { pthread_mutex_unlock(&mutex_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;
  Lock(Lock&&) = delete;
  Lock& operator=(Lock&&) = delete;

 private:
  pthread_mutex_t& mutex_;
};

void sleep_ms(std::uint32_t ms) {
  const timespec time{.tv_sec = ms / 1000, .tv_nsec = static_cast<long>(ms % 1000) * 1'000'000};
  ::nanosleep(&time, nullptr);
}

}  // namespace

int cores_available() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

Worker::Worker(const WorkerOptions& options) : options_(options) {
  // The steps wait for the worker's thread: the one that holds the lock gets the other's priority.
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
  pthread_mutex_init(&mutex_, &attributes);
  pthread_mutexattr_destroy(&attributes);
  pthread_cond_init(&changed_, nullptr);
  if (options_.own_thread) {
    start_thread();
  }
}

Worker::~Worker() {
  if (state_.own_thread) {
    {
      const Lock lock(mutex_);
      stop_ = true;
      pthread_cond_broadcast(&changed_);
    }
    pthread_join(thread_, nullptr);
  }
  pthread_cond_destroy(&changed_);
  pthread_mutex_destroy(&mutex_);
}

void Worker::start_thread() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  // Set explicitly: the default is the shell's limit, 8 MB and more of address space a thread.
  pthread_attr_setstacksize(&attributes, options_.stack_bytes);
  const int problem = pthread_create(&thread_, &attributes, thread_main, this);
  pthread_attr_destroy(&attributes);
  if (problem != 0) {
    throw RunFailure(std::string("the thread for jobs cannot be made: ") + std::strerror(problem));
  }
  state_.own_thread = true;
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  ::sched_getaffinity(0, sizeof allowed, &allowed);
  if (CPU_ISSET(static_cast<unsigned>(options_.core), &allowed)) {
    cpu_set_t wanted;
    CPU_ZERO(&wanted);
    CPU_SET(static_cast<unsigned>(options_.core), &wanted);
    state_.bound_to_core = pthread_setaffinity_np(thread_, sizeof wanted, &wanted) == 0;
  }
  if (options_.priority > 0) {
    const sched_param requested{.sched_priority = options_.priority};
    state_.real_time = pthread_setschedparam(thread_, SCHED_FIFO, &requested) == 0;
  }
}

void* Worker::thread_main(void* worker) {
  static_cast<Worker*>(worker)->serve();
  return nullptr;
}

Worker::Entry* Worker::next() {
  Entry* const found = std::find_if(
      entries_.begin(), entries_.end(), [](const Entry& entry) { return !entry.done; });
  return found == entries_.end() ? nullptr : found;
}

void Worker::serve() {
  const Lock lock(mutex_);
  for (;;) {
    while (!stop_ && next() == nullptr) {
      pthread_cond_wait(&changed_, &mutex_);
    }
    if (next() == nullptr) {
      return;
    }
    Job* const job = next()->job;
    pthread_mutex_unlock(&mutex_);
    const Duration duration = run(job);
    pthread_mutex_lock(&mutex_);
    // Others may have been handed back meanwhile, never this one: it is still the first.
    next()->duration = duration;
    next()->done = true;
    pthread_cond_broadcast(&changed_);
  }
}

bool Worker::admitted() const {
  return !memory_is_sealed() || !memory_is_fixed() ||
         pool_use(Pool::kJobs).largest_free_bytes >= options_.job_bytes;
}

Worker::Duration Worker::run(Job* job) {
  if (options_.latency_ms_max > 0) {
    constexpr std::uint64_t kStream = 6101;
    Rng rng(runs_, kStream);
    sleep_ms(rng.below(options_.latency_ms_max + 1));
  }
  ++runs_;
  const Clock::time_point start = Clock::now();
  const PoolScope scope(Pool::kJobs);
  if (admitted()) {
    run_job(*job);
  } else {
    skip_job(*job);
  }
  return Clock::now() - start;
}

void Worker::submit(const Jobs& jobs) {
  for (Job* const job : jobs) {
    const Duration duration = state_.own_thread ? Duration{} : run(job);
    const Lock lock(mutex_);
    const bool stored =
        entries_.push_back({.job = job, .done = !state_.own_thread, .duration = duration});
    POLHODE_ASSERT(stored, entries_.size());
    pthread_cond_broadcast(&changed_);
  }
}

bool Worker::late_for(std::uint32_t step) {
  const Lock lock(mutex_);
  return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return !entry.done && step >= due_step(*entry.job);
  });
}

/// With the lock held.
void Worker::wait_until_done(const Job* job) {
  const auto is_done = [&] {
    return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& entry) {
      return entry.job == job && entry.done;
    });
  };
  while (!is_done()) {
    pthread_cond_wait(&changed_, &mutex_);
  }
}

Jobs Worker::due(std::uint32_t step) {
  Jobs finished;
  durations_.clear();
  const Lock lock(mutex_);
  for (std::size_t i = 0; i < entries_.size();) {
    Job* const job = entries_[i].job;
    if (step < due_step(*job)) {
      ++i;
      continue;
    }
    wait_until_done(job);
    (void)finished.push_back(job);
    (void)durations_.push_back(entries_[i].duration);
    entries_.erase(i);
  }
  return finished;
}

void Worker::finish() {
  const Lock lock(mutex_);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    wait_until_done(entries_[i].job);
  }
  entries_.clear();
}

}  // namespace polhode::platform
