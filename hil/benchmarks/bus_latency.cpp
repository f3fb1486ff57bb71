// How long a packet takes from the sender to a reader in another process, what is lost, and how
// long sending takes, with two good readers and a stopped one on each transport.
//   bus_latency [--seconds 10] [--rate 1000] [--load 4] [--priority 5] [--core -1] [--ordinary 1]
//   [--only unix|shm|udp]
// Two tables, both beside --load programs that want a core each: the first as in flight, sender and
// readers at real-time priority with their memory locked (run.priority, run.lock_memory; a reader
// that closes a loop comes before the estimator, so it has one more), the second at ordinary
// priority, which tells more of how the system shares its cores than of the bus. --priority 0: the
// second alone; --ordinary 0: the first alone. --core: sender and readers on one core (run.core,
// and a reader's own choice), the load on all. One line a transport, after one for the machine's
// own part: two processes woken by a word in shared memory, with nothing sent. Exit status 1 when a
// good reader lost a packet or the heap was called.
#include <fmt/format.h>
#include <linux/futex.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "bus/telemetry.hpp"
#include "os/linux/clock.hpp"
#include "platform/temporary_folder.hpp"
#include "processes.hpp"
#include "tests/bus/motion_packet.hpp"
#include "transport/client/c/polhode_bus.h"
#include "transport/transports.hpp"

namespace {

std::atomic<std::uint64_t> heap_calls{0};

}  // namespace

// Every request for heap in this program and the libraries below it goes through here.
extern "C" void* __libc_malloc(std::size_t octets);
extern "C" void* malloc(std::size_t octets) {
  heap_calls.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(octets);
}

namespace {

using namespace polhode;
using namespace polhode::platform;
using namespace polhode::benchmarks;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kSamplesMax = 400'000;
constexpr int kGoodReaders = 2;

/// What a reader process tells its parent, in memory that both see.
struct ReaderResult {
  std::atomic<bool> ready;
  std::uint64_t packets;
  std::uint64_t missing;
  std::uint64_t heap_calls;
  std::uint32_t latency_ns[kSamplesMax];
};

void read_all(const std::string& address, ReaderResult& result) {
  static polhode_bus bus;
  if (polhode_bus_open(&bus, address.c_str()) != 0) {
    std::_Exit(2);
  }
  std::uint8_t packet[POLHODE_PACKET_OCTETS_MAX];
  polhode_motion motion;
  result.ready = true;
  const std::uint64_t before = heap_calls;
  for (;;) {
    const int octets = polhode_bus_next(&bus, packet, sizeof packet, 3000);
    const std::int64_t at_ns = clock_ns(CLOCK_MONOTONIC);
    if (octets <= 0 ||
        polhode_decode(
            packet, static_cast<std::size_t>(octets), POLHODE_MOTION, &motion, sizeof motion) !=
            0) {
      break;
    }
    if (motion.mode == POLHODE_MOTION_MODE_LOST) {  // the sender's last word
      break;
    }
    if (result.packets < kSamplesMax) {
      result.latency_ns[result.packets] = static_cast<std::uint32_t>(
          std::min<std::int64_t>(at_ns - motion.timestamp_ns, UINT32_MAX));
    }
    ++result.packets;
  }
  result.heap_calls = heap_calls - before;
  result.missing = bus.missing;
  polhode_bus_close(&bus);
}

struct Reader {
  pid_t process = 0;
  ReaderResult* result = nullptr;
};

template <typename Read>
Reader start_reader(int priority, Read read) {
  Reader reader{.process = 0, .result = make_shared_memory<ReaderResult>()};
  reader.process = start_process(priority > 0 ? priority + 1 : 0, [&] { read(*reader.result); });
  while (!reader.result->ready) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return reader;
}

struct Sent {
  std::uint64_t packets = 0;
  std::uint64_t heap_calls = 0;
  std::vector<std::uint32_t> send_ns;  ///< how long each send took
};

struct Wish {
  int seconds = 10;
  int rate = 1000;
  int load = 4;
  int priority = 5;  ///< 0: an ordinary one
  int core = -1;     ///< of sender and readers, as run.core; -1: any
  int ordinary = 1;  ///< 0: no second table
  std::string only;  ///< empty: all
};

Sent send_all(Transports& transports, const Wish& request) {
  Sent sent;
  const auto total =
      static_cast<std::uint64_t>(request.seconds) * static_cast<std::uint64_t>(request.rate);
  sent.send_ns.reserve(total);
  MotionState state;
  std::vector<std::uint8_t> octets(kMotionPacketOctets);
  const auto period = std::chrono::nanoseconds(1'000'000'000 / request.rate);
  auto due = Clock::now();
  const std::uint64_t before = heap_calls;
  for (std::uint64_t i = 0; i < total; ++i, due += period) {
    std::this_thread::sleep_until(due);
    state.frame = static_cast<std::uint32_t>(i);
    state.timestamp_ns = clock_ns(CLOCK_MONOTONIC);
    (void)encode_motion(state, {}, static_cast<std::uint16_t>(i & 0x3FFF), octets);
    transports.send(octets);
    sent.send_ns.push_back(
        static_cast<std::uint32_t>(clock_ns(CLOCK_MONOTONIC) - state.timestamp_ns));
    ++sent.packets;
  }
  sent.heap_calls = heap_calls - before;
  state.mode = Mode::kLost;
  (void)encode_motion(state, {}, static_cast<std::uint16_t>(total & 0x3FFF), octets);
  transports.send(octets);
  return sent;
}

/// A word that two processes wait at.
struct Bell {
  static constexpr std::size_t kTimes = 1024;
  std::atomic<std::uint32_t> rung = 0;
  std::atomic<bool> over = false;
  std::atomic<std::int64_t> at_ns[kTimes] = {};
};

void hear(Bell& bell, ReaderResult& result) {
  std::uint32_t heard = 0;
  result.ready = true;
  while (!bell.over) {
    ::syscall(SYS_futex, &bell.rung, FUTEX_WAIT, heard, nullptr, nullptr, 0);
    const std::uint32_t rung = bell.rung;
    const std::int64_t now =
        clock_ns(CLOCK_MONOTONIC);  // after it: a later ring would else seem heard before it rang
    if (rung != heard && result.packets < kSamplesMax) {
      result.latency_ns[result.packets++] =
          static_cast<std::uint32_t>(now - bell.at_ns[rung % Bell::kTimes]);
    }
    heard = rung;
  }
}

/// What waking two processes costs on this machine as it is loaded now.
void measure_waking(const Wish& request) {
  Bell* bell = make_shared_memory<Bell>();
  std::vector<Reader> readers;
  for (int i = 0; i < kGoodReaders; ++i) {
    readers.push_back(
        start_reader(request.priority, [bell](ReaderResult& result) { hear(*bell, result); }));
  }
  const auto total = static_cast<std::uint32_t>(request.seconds * request.rate);
  std::vector<std::uint32_t> waking_ns;
  auto due = Clock::now();
  for (std::uint32_t i = 1; i <= total;
       ++i, due += std::chrono::nanoseconds(1'000'000'000 / request.rate)) {
    std::this_thread::sleep_until(due);
    const std::int64_t before_ns = clock_ns(CLOCK_MONOTONIC);
    bell->at_ns[i % Bell::kTimes] = before_ns;
    bell->over = i == total;
    bell->rung = i;
    ::syscall(SYS_futex, &bell->rung, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
    waking_ns.push_back(static_cast<std::uint32_t>(clock_ns(CLOCK_MONOTONIC) - before_ns));
  }
  std::vector<std::uint32_t> latency;
  for (const Reader& reader : readers) {
    ::waitpid(reader.process, nullptr, 0);
    latency.insert(latency.end(),
                   reader.result->latency_ns,
                   reader.result->latency_ns + reader.result->packets);
  }
  fmt::print("{:<14} {:>8} {:>6} {:>9.1f} {:>9.1f} {:>9.1f}   {:>9.1f} {:>9.1f} {:>9.1f}\n",
             "(waking alone)",
             total,
             "",
             percentile_us(latency, 0.5),
             percentile_us(latency, 0.99),
             percentile_us(latency, 1.0),
             percentile_us(waking_ns, 0.5),
             percentile_us(waking_ns, 0.99),
             percentile_us(waking_ns, 1.0));
  std::fflush(stdout);
}

/// @return true when nothing was lost and no heap was used.
bool measure(const char* name, const std::vector<std::string>& addresses, const Wish& request) {
  // The shared-memory ring has to be there before its readers.
  const bool shared = addresses[0].starts_with("shm:");
  const std::vector<std::string> unique = shared ? std::vector{addresses[0]} : addresses;
  std::vector<Reader> readers;
  Transports early({.send = shared ? unique : std::vector<std::string>(), .receive = {}});
  for (const std::string& address : addresses) {
    readers.push_back(
        start_reader(request.priority, [&](ReaderResult& result) { read_all(address, result); }));
  }
  ::kill(readers.back().process, SIGSTOP);
  Transports later({.send = shared ? std::vector<std::string>() : unique, .receive = {}});
  const Sent sent = send_all(shared ? early : later, request);
  bool good = sent.heap_calls == 0;
  std::vector<std::uint32_t> latency;
  std::uint64_t lost = 0;
  std::uint64_t heap = sent.heap_calls;
  for (int i = 0; i < kGoodReaders; ++i) {
    ::waitpid(readers[static_cast<std::size_t>(i)].process, nullptr, 0);
    const ReaderResult& result = *readers[static_cast<std::size_t>(i)].result;
    lost += sent.packets - result.packets;
    heap += result.heap_calls;
    latency.insert(latency.end(),
                   result.latency_ns,
                   result.latency_ns + std::min<std::uint64_t>(result.packets, kSamplesMax));
  }
  end_process(readers.back().process);
  good = good && lost == 0 && heap == 0;
  fmt::print("{:<14} {:>8} {:>6} {:>9.1f} {:>9.1f} {:>9.1f}   {:>9.1f} {:>9.1f} {:>9.1f} {:>6}\n",
             name,
             sent.packets,
             lost,
             percentile_us(latency, 0.5),
             percentile_us(latency, 0.99),
             percentile_us(latency, 1.0),
             percentile_us(sent.send_ns, 0.5),
             percentile_us(sent.send_ns, 0.99),
             percentile_us(sent.send_ns, 1.0),
             heap);
  std::fflush(stdout);
  return good;
}

/// One table. @return true when nothing was lost and no heap was used.
bool measure_all(const std::string& folder, const Wish& request) {
  if (!set_core(request.core)) {
    fmt::print("core {} is not granted\n", request.core);
    return true;
  }
  if (!set_priority(request.priority)) {
    fmt::print("real-time priority {} is not granted (ulimit -r)\n", request.priority);
    return true;
  }
  const std::string scheduling =
      request.priority > 0 ? fmt::format("real-time priority {}, readers {}, memory locked",
                                         request.priority,
                                         request.priority + 1)
                           : "ordinary priority";
  const std::string cores =
      request.core < 0 ? "any core" : fmt::format("core {} for all", request.core);
  fmt::print("{}, {}; {} programs beside it\n", scheduling, cores, request.load);
  fmt::print("{:<14} {:>8} {:>6} {:>29}   {:>29} {:>6}\n",
             "",
             "packets",
             "lost",
             "to a reader, us: p50 p99 max",
             "sending, us: p50 p99 max",
             "heap");
  const std::string ring = fmt::format("shm:/polhode_latency_{}", ::getpid());
  measure_waking(request);
  bool good = true;
  const auto one = [&](const char* name, const std::vector<std::string>& addresses) {
    if (addresses[0].starts_with(request.only)) {
      good = measure(name, addresses, request) && good;
    }
  };
  one("unix datagram",
      {"unix:" + folder + "/a", "unix:" + folder + "/b", "unix:" + folder + "/stopped"});
  one("shared memory", {ring, ring, ring});
  one("udp loopback", {"udp:39301", "udp:39302", "udp:39303"});
  ::shm_unlink(ring.c_str() + 4);
  (void)set_priority(0);
  return good;
}

/// @return false for what is no option of this program.
bool read_wish(int argc, char** argv, Wish& request) {
  for (int i = 1; i < argc; i += 2) {
    const std::string_view name = argv[i];
    int* const value = name == "--seconds"    ? &request.seconds
                       : name == "--rate"     ? &request.rate
                       : name == "--load"     ? &request.load
                       : name == "--priority" ? &request.priority
                       : name == "--core"     ? &request.core
                       : name == "--ordinary" ? &request.ordinary
                                              : nullptr;
    if (i + 1 == argc || (value == nullptr && name != "--only")) {
      fmt::print(stderr,
                 "bus_latency [--seconds 10] [--rate 1000] [--load 4] [--priority 5] [--core -1] "
                 "[--ordinary 1] [--only unix|shm|udp]\n");
      return false;
    }
    if (value == nullptr) {
      request.only = argv[i + 1];
      continue;
    }
    *value = std::atoi(argv[i + 1]);
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  Wish request;
  if (!read_wish(argc, argv, request)) {
    return 2;
  }
  const TemporaryFolder temporary;
  const std::string folder = temporary.path().string();
  const Load load(request.load);
  bool good = true;
  if (request.priority > 0) {
    good = measure_all(folder, request);
  }
  if (request.ordinary != 0) {
    request.priority = 0;
    good = measure_all(folder, request) && good;
  }
  return good ? 0 : 1;
}
