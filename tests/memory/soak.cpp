// Many frames after the seal: a sequence played back and forth from memory, on two threads, under
// the kernel's eyes. Prints what it found as JSON; exit code 5 shows that something asked the
// machine for memory, a thread or a file.
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/component_memory.hpp"
#include "base/median.hpp"
#include "camera/replay/sequence.hpp"
#include "errors.hpp"
#include "os/linux/clock.hpp"
#include "os/linux/libraries.hpp"
#include "os/linux/memory/lock.hpp"
#include "os/linux/memory/region.hpp"
#include "os/linux/memory/trap.hpp"
#include "os/linux/worker.hpp"
#include "parameters/load.hpp"
#include "pipeline/component.hpp"
#include "platform/decoded_sequence.hpp"

namespace {

using namespace polhode;
using namespace polhode::platform;

struct Arguments {
  std::string config;
  std::string sequence;
  std::vector<std::string> settings;
  int warm_up = 200;
  int frames = 500;
  std::string control;  ///< a forbidden call to make on purpose
};

struct Reading {
  long faults = 0;
  long resident_pages = 0;
  std::size_t live_blocks = 0;
  std::size_t used_bytes = 0;
};

class Meter {
 public:
  Meter() : file_(std::fopen("/proc/self/statm", "r")) {}
  Reading read() {
    Reading r;
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    r.faults = usage.ru_minflt + usage.ru_majflt;
    char text[128]{};
    if (::pread(::fileno(file_), text, sizeof text - 1, 0) > 0) {
      long total = 0;
      (void)std::sscanf(text, "%ld %ld", &total, &r.resident_pages);
    }
    for (std::size_t i = 0; i < kPoolCount; ++i) {
      const HeapUse use = pool_use(static_cast<Pool>(i));
      r.live_blocks += use.live_blocks;
      r.used_bytes += use.used_bytes;
    }
    return r;
  }

 private:
  std::FILE* file_;
};

/// The positive control: shows that the trap would have seen it.
void do_what_is_forbidden(const std::string& control) {
  if (control == "mmap") {
    (void)::mmap(nullptr, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  } else if (control == "brk") {
    (void)::sbrk(4096);
  } else if (control == "open") {
    (void)std::fopen("/dev/null", "r");
  } else if (control == "thread") {
    pthread_t thread{};
    pthread_create(
        &thread, nullptr, [](void* p) { return p; }, nullptr);
  } else if (control == "madvise") {
    alignas(4096) static char page[4096];
    (void)::madvise(page, sizeof page, MADV_NORMAL);
  }
}

class Soak {
 public:
  Soak(const Arguments& arguments, const Sequence& sequence, const Parameters& parameters)
      : arguments_(arguments),
        parameters_(parameters),
        frames_(sequence),
        memory_(parameters, arguments.config, {}),
        worker_({.own_thread = has_work_beside(parameters.jobs)}) {
    Result<Component*> made = Component::create(memory_.span(), parameters);
    if (!made) {
      throw UnusableInput(made.error().message);
    }
    component_ = made.value();
    step_ms_.reserve(static_cast<std::size_t>(arguments.frames));
  }

  void run() {
    for (int i = 0; i < arguments_.warm_up; ++i) {
      step();
    }
    const std::string lock_problem = lock_memory();
    Reading at_seal = meter_.read();
    seal_memory();
    const bool trapped = set_memory_trap(true);
    do_what_is_forbidden(arguments_.control);
    std::vector<Reading> readings;
    readings.reserve(11);
    at_seal = meter_.read();
    for (int i = 0; i < arguments_.frames; ++i) {
      if (i % std::max(1, arguments_.frames / 10) == 0) {
        readings.push_back(meter_.read());
      }
      step();
    }
    readings.push_back(meter_.read());
    print(at_seal, readings, trapped, lock_problem.empty());
    std::fflush(stdout);
    ::_exit(0);  // ending the thread would be trapped
  }

 private:
  void step() {
    const Frame frame = frames_.frame(next_++);
    const PoolScope scope(Pool::kStep);
    const Jobs finished = worker_.due(component_->next_step());
    const std::int64_t before_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID);
    const StepOutput& out = component_->step({.frame = frame, .finished = finished});
    if (memory_is_sealed()) {
      step_ms_.push_back(1e-6 * static_cast<double>(clock_ns(CLOCK_THREAD_CPUTIME_ID) - before_ns));
      poses_ += out.motion.pose_valid ? 1 : 0;
    }
    worker_.submit(out.jobs);
  }

  [[nodiscard]] double median_ms(std::size_t from, std::size_t count) const {
    std::vector<double> part(
        step_ms_.begin() + static_cast<std::ptrdiff_t>(from),
        step_ms_.begin() + static_cast<std::ptrdiff_t>(std::min(from + count, step_ms_.size())));
    return median(std::span(part));
  }

  void print(const Reading& at_seal,
             const std::vector<Reading>& readings,
             bool trapped,
             bool locked) {
    std::string live;
    std::string used;
    std::string resident;
    for (const Reading& r : readings) {
      const char* comma = live.empty() ? "" : ", ";
      live += fmt::format("{}{}", comma, r.live_blocks);
      used += fmt::format("{}{}", comma, r.used_bytes);
      resident += fmt::format("{}{}", comma, r.resident_pages * 4096);
    }
    const std::size_t tenth = step_ms_.size() / 10;
    fmt::print(
        "{{\"frames\": {}, \"poses\": {}, \"trap\": {}, \"locked\": {},\n"
        " \"faults_after_seal\": {}, \"live_blocks\": [{}],\n \"used_octets\": [{}],\n"
        " \"resident_octets\": [{}],\n \"grown_octets\": {}, \"overdrafts\": {},\n"
        " \"median_step_ms_second_tenth\": {:.3f}, \"median_step_ms_last_tenth\": {:.3f}}}\n",
        arguments_.frames,
        poses_,
        trapped,
        locked,
        readings.back().faults - at_seal.faults,
        live,
        used,
        resident,
        grown_bytes(),
        take_overdrafts(Pool::kStep) + take_overdrafts(Pool::kJobs) +
            take_overdrafts(Pool::kGeneral),
        median_ms(tenth, tenth),
        median_ms(9 * tenth, tenth));
  }

  const Arguments& arguments_;
  const Parameters& parameters_;
  DecodedSequence frames_;
  ComponentMemory memory_;
  Worker worker_;
  Meter meter_;
  Component* component_ = nullptr;
  std::size_t next_ = 0;
  int poses_ = 0;
  std::vector<double> step_ms_;
};

}  // namespace

int main(int argc, char** argv) {
  pin_libraries();
  Arguments arguments;
  CLI::App app{"many frames after the seal"};
  app.add_option("--config", arguments.config)->required();
  app.add_option("--sequence", arguments.sequence)->required();
  app.add_option("--set", arguments.settings)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--warm-up", arguments.warm_up);
  app.add_option("--frames", arguments.frames);
  app.add_option("--control", arguments.control);
  CLI11_PARSE(app, argc, argv);
  try {
    const Sequence sequence = open_sequence(arguments.sequence);
    Parameters parameters = load_configuration(arguments.config, arguments.settings).parameters;
    parameters.camera = sequence.camera;
    Soak(arguments, sequence, parameters).run();
  } catch (const std::exception& problem) {
    fmt::print(stderr, "soak: {}\n", problem.what());
    return 2;
  }
}
