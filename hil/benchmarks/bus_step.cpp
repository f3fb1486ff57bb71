// Does a reader delay a step? The component steps through a sequence, back and forth, at a camera's
// pace, and publishes on every transport, filled up to so many packets a second: for a while with
// nobody there, for as long with two good readers and a stopped one on each transport, in turns.
// Each turn takes the same steps, so that two with nobody there show what the machine does by
// itself.
//   bus_step --config config/live.toml --sequence hil/data/sample [--seconds 60] [--turns 5]
//            [--rate 1000] [--fps 25] [--load 0] [--priority 5] [--set key=value ...]
// With --priority over 0 the steps are at that real-time priority, the readers at one more, as in
// flight. Waits: how often publishing gave up the processor; sockets and ring never do, a file does
// when the disk is busy. Exit status 1 when a good reader lost a packet.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "app/component_memory.hpp"
#include "app/next_input.hpp"
#include "base/median.hpp"
#include "bus/telemetry.hpp"
#include "camera/replay/sequence.hpp"
#include "os/linux/clock.hpp"
#include "os/linux/libraries.hpp"
#include "os/linux/worker.hpp"
#include "parameters/load.hpp"
#include "pipeline/component.hpp"
#include "platform/decoded_sequence.hpp"
#include "platform/temporary_folder.hpp"
#include "processes.hpp"
#include "tests/bus/motion_packet.hpp"
#include "transport/client/c/polhode_bus.h"
#include "transport/transports.hpp"

namespace {

using namespace polhode;
using namespace polhode::platform;
using namespace polhode::benchmarks;

constexpr int kGoodReaders = 2;
constexpr std::uint16_t kFillerApids = 0x400;  // beside the component's own

struct Arguments {
  std::string config;
  std::string sequence;
  std::vector<std::string> settings;
  int seconds = 60;  ///< with nobody there, and as many with readers
  int turns = 5;     ///< in so many parts
  int rate = 1000;
  int fps = 25;
  int load = 0;
  int priority = 5;
};

/// What a reader process tells, in memory that both see.
struct Heard {
  std::atomic<bool> ready;
  std::atomic<bool> over;  ///< told to the reader: nothing more will come
  std::uint64_t packets;
  std::uint64_t missing;
};

void listen(const std::string& address, Heard& heard) {
  static polhode_bus bus;
  if (polhode_bus_open(&bus, address.c_str()) != 0) {
    std::_Exit(2);
  }
  std::uint8_t packet[POLHODE_PACKET_OCTETS_MAX];
  heard.ready = true;
  for (bool more = true; more;) {
    more = polhode_bus_next(&bus, packet, sizeof packet, 200) > 0 || !heard.over;
    heard.packets = bus.packets;
  }
  heard.missing = bus.missing;
  polhode_bus_close(&bus);
}

/// Two good readers and a stopped one on each transport; gone with this object.
class Audience {
 public:
  Audience(const std::vector<std::vector<std::string>>& addresses, int priority) {
    for (const std::vector<std::string>& transport : addresses) {
      for (const std::string& address : transport) {
        Heard* heard = make_shared_memory<Heard>();
        const pid_t process =
            start_process(priority > 0 ? priority + 1 : 0, [&] { listen(address, *heard); });
        while (!heard->ready) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        const bool stopped = &address == &transport.back();
        if (stopped) {
          ::kill(process, SIGSTOP);
          stopped_.push_back(process);
        } else {
          good_.push_back({process, heard});
        }
      }
    }
  }
  ~Audience() {
    for (const pid_t process : stopped_) end_process(process);
    for (const Good& good : good_) end_process(good.process);
  }
  Audience(const Audience&) = delete;
  Audience& operator=(const Audience&) = delete;

  /// Packets that did not reach a good reader of those `published`, of all good readers together.
  std::uint64_t lost(std::uint64_t published) {
    std::uint64_t sum = 0;
    for (const Good& good : good_) good.heard->over = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    for (const Good& good : good_) sum += published - good.heard->packets;
    return sum;
  }

 private:
  struct Good {
    pid_t process;
    Heard* heard;
  };
  std::vector<Good> good_;
  std::vector<pid_t> stopped_;
};

/// One run through the frames.
struct Times {
  std::vector<std::uint32_t> step_ns;      ///< by the wall
  std::vector<std::uint32_t> step_cpu_ns;  ///< of the stepping thread
  std::vector<std::uint32_t> publish_ns;   ///< the step's own packets, on all transports
  std::uint64_t published = 0;
  long publish_waits = 0;  ///< how often publishing gave up the processor of its own accord
};

long waits() {
  rusage use{};
  ::getrusage(RUSAGE_THREAD, &use);
  return use.ru_nvcsw;
}

std::uint64_t packets_in(std::span<const std::uint8_t> octets) {
  std::uint64_t count = 0;
  bus::PacketHeader header;
  for (std::size_t at = 0; at < octets.size() && bus::read_header(octets.subspan(at), header);
       at += header.total_octets) {
    ++count;
  }
  return count;
}

class Bench {
 public:
  Bench(const Arguments& arguments, const Sequence& sequence, const Parameters& parameters)
      : arguments_(arguments),
        parameters_(parameters),
        frames_(sequence),
        memory_(parameters, arguments.config, {}) {}

  Times run(Transports& transports) {
    Result<Component*> made = Component::create(memory_.span(), parameters_);
    Component& component = *made.value();
    Worker worker({.own_thread = has_work_beside(parameters_.jobs)});
    Times times;
    const auto frames =
        static_cast<std::size_t>(arguments_.seconds * arguments_.fps / arguments_.turns);
    const auto slot = std::chrono::nanoseconds(1'000'000'000 / arguments_.fps);
    filler_ = 0;
    auto due = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < frames; ++i) {
      std::this_thread::sleep_until(due);
      step(component, worker, i, transports, times);
      due += slot;
      fill(transports,
           due,
           times,
           arguments_.rate * (i + 1) / static_cast<std::size_t>(arguments_.fps));
    }
    worker.finish();
    transports.flush();
    return times;
  }

 private:
  void step(Component& component,
            Worker& worker,
            std::size_t number,
            Transports& transports,
            Times& times) const {
    const StepInput input = next_input(component, worker, frames_.frame(number));
    const std::int64_t before_ns = clock_ns(CLOCK_MONOTONIC);
    const std::int64_t cpu_before_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID);
    const StepOutput& out = component.step(input);
    const std::int64_t cpu_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID) - cpu_before_ns;
    const std::int64_t stepped_ns = clock_ns(CLOCK_MONOTONIC);
    worker.submit(out.jobs);
    const long waits_before = waits();
    const std::int64_t submitted_ns = clock_ns(CLOCK_MONOTONIC);
    transports.send(out.packets);
    times.publish_ns.push_back(
        static_cast<std::uint32_t>(clock_ns(CLOCK_MONOTONIC) - submitted_ns));
    times.publish_waits += waits() - waits_before;
    times.step_ns.push_back(static_cast<std::uint32_t>(stepped_ns - before_ns));
    times.step_cpu_ns.push_back(static_cast<std::uint32_t>(cpu_ns));
    times.published += packets_in(out.packets);
  }

  /// One packet a millisecond or so until the next frame is due, then what is left of those that
  /// have to be out by then.
  void fill(Transports& transports,
            std::chrono::steady_clock::time_point until,
            Times& times,
            std::size_t published_then) {
    std::vector<std::uint8_t> octets(kMotionPacketOctets);
    BusOptions options;
    options.apid_first = kFillerApids;
    while (times.published < published_then) {
      const std::size_t left = published_then - times.published;
      const auto now = std::chrono::steady_clock::now();
      if (now < until) {
        std::this_thread::sleep_until(now + (until - now) / (left + 1));
      }
      (void)encode_motion({}, options, static_cast<std::uint16_t>(filler_++ & 0x3FFF), octets);
      const long before = waits();
      transports.send(octets);
      times.publish_waits += waits() - before;
      ++times.published;
    }
  }

  const Arguments& arguments_;
  const Parameters& parameters_;
  DecodedSequence frames_;
  ComponentMemory memory_;
  std::size_t filler_ = 0;
};

void print(const char* name, const Times& times, std::uint64_t lost) {
  const auto three = [](const std::vector<std::uint32_t>& ns) {
    return fmt::format("{:>8.2f} {:>6.2f} {:>6.2f}",
                       1e-3 * percentile_us(ns, 0.5),
                       1e-3 * percentile_us(ns, 0.99),
                       1e-3 * percentile_us(ns, 1.0));
  };
  fmt::print("{:<14} {:>8} {:>6}   {}   {}   {:>7.1f} {:>7.1f} {:>7.1f}   {:>5}\n",
             name,
             times.published,
             lost,
             three(times.step_ns),
             three(times.step_cpu_ns),
             percentile_us(times.publish_ns, 0.5),
             percentile_us(times.publish_ns, 0.99),
             percentile_us(times.publish_ns, 1.0),
             times.publish_waits);
  std::fflush(stdout);
}

/// The same steps, each with itself: of the quotients of their times the median, and that of the
/// sums, less 1.
struct Comparison {
  std::vector<double> quotients;
  double sum_a = 0.0;
  double sum_b = 0.0;

  void add(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      quotients.push_back(static_cast<double>(b[i]) / static_cast<double>(a[i]));
      sum_a += a[i];
      sum_b += b[i];
    }
  }
  void print(const char* name) {
    fmt::print("{:<46} median {:+.2f} %, mean {:+.2f} %\n",
               name,
               100.0 * (median(std::span(quotients)) - 1.0),
               100.0 * (sum_b / sum_a - 1.0));
  }
};

void append(Times& all, const Times& part) {
  all.step_ns.insert(all.step_ns.end(), part.step_ns.begin(), part.step_ns.end());
  all.step_cpu_ns.insert(all.step_cpu_ns.end(), part.step_cpu_ns.begin(), part.step_cpu_ns.end());
  all.publish_ns.insert(all.publish_ns.end(), part.publish_ns.begin(), part.publish_ns.end());
  all.published += part.published;
  all.publish_waits += part.publish_waits;
}

struct Addresses {
  std::vector<std::vector<std::string>>
      readers;  ///< of each transport; the last one is the stopped one
  std::vector<std::string> send;
};

Addresses addresses_in(const std::string& folder) {
  const std::string ring = fmt::format("shm:/polhode_step_{}", ::getpid());
  return {
      .readers = {{"unix:" + folder + "/a", "unix:" + folder + "/b", "unix:" + folder + "/stopped"},
                  {ring, ring, ring},
                  {"udp:39311", "udp:39312", "udp:39313"}},
      .send = {"unix:" + folder + "/stopped",
               "unix:" + folder + "/a",
               "unix:" + folder + "/b",
               ring,
               "udp:39313",
               "udp:39311",
               "udp:39312",
               "file:" + folder + "/flight.ccsds"}};
}

/// @return true when nothing was lost.
bool measure(const Arguments& arguments,
             const Sequence& sequence,
             const Parameters& parameters,
             const std::string& folder) {
  Bench bench(arguments, sequence, parameters);
  const Addresses addresses = addresses_in(folder);
  Transports transports({.send = addresses.send, .receive = {}});
  const Load load(arguments.load);
  if (!set_priority(arguments.priority)) {
    fmt::print("real-time priority {} is not granted (ulimit -r): ordinary priority\n",
               arguments.priority);
  }
  fmt::print("steps at priority {}, {} frames a second, {} programs beside it\n",
             arguments.priority,
             arguments.fps,
             arguments.load);
  fmt::print("{:<14} {:>8} {:>6}   {:>22}   {:>22}   {:>23}   {:>5}\n",
             "",
             "packets",
             "lost",
             "step, ms: p50 p99 max",
             "of it CPU",
             "publishing, us",
             "waits");
  Times nobody;
  Times heard;
  Comparison with_readers;
  Comparison without;
  std::uint64_t lost = 0;
  for (int turn = 0; turn < arguments.turns; ++turn) {
    const Times first = bench.run(transports);
    auto readers = std::make_unique<Audience>(addresses.readers, arguments.priority);
    const Times second = bench.run(transports);
    lost += readers->lost(second.published);
    readers.reset();
    if (turn > 0) {
      without.add({nobody.step_ns.end() - static_cast<std::ptrdiff_t>(first.step_ns.size()),
                   nobody.step_ns.end()},
                  first.step_ns);
    }
    with_readers.add(first.step_ns, second.step_ns);
    append(nobody, first);
    append(heard, second);
  }
  set_priority(0);
  print("nobody there", nobody, 0);
  print("with readers", heard, lost);
  with_readers.print("steps with readers against those without:");
  if (arguments.turns > 1) {
    without.print("steps without readers against the turn before:");
  }
  ::shm_unlink(addresses.readers[1][0].c_str() + 4);
  return lost == 0;
}

}  // namespace

int main(int argc, char** argv) {
  pin_libraries();
  Arguments arguments;
  CLI::App app{"steps beside readers"};
  app.add_option("--config", arguments.config)->required();
  app.add_option("--sequence", arguments.sequence)->required();
  app.add_option("--set", arguments.settings)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--seconds", arguments.seconds);
  app.add_option("--turns", arguments.turns)->check(CLI::PositiveNumber);
  app.add_option("--rate", arguments.rate);
  app.add_option("--fps", arguments.fps);
  app.add_option("--load", arguments.load);
  app.add_option("--priority", arguments.priority);
  CLI11_PARSE(app, argc, argv);
  const TemporaryFolder folder;
  bool good = false;
  try {
    const Sequence sequence = open_sequence(arguments.sequence);
    Parameters parameters = load_configuration(arguments.config, arguments.settings).parameters;
    parameters.camera = sequence.camera;
    good = measure(arguments, sequence, parameters, folder.path().string());
  } catch (const std::exception& problem) {
    fmt::print(stderr, "bus_step: {}\n", problem.what());
  }
  return good ? 0 : 1;
}
