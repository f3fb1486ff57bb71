// How long a packet takes from the sender to a reader in another process, what is lost, and how long
// sending takes, with two good readers and a stopped one on each transport.
//   bus_latency [--seconds 10] [--rate 1000]
// One line a transport, after one for the machine's own part: two processes woken by a word in shared
// memory, with nothing sent. Exit status 1 when a good reader lost a packet or the heap was called.
#include <fmt/format.h>
#include <linux/futex.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <climits>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "bus/telemetry.hpp"
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
using Clock = std::chrono::steady_clock;

constexpr std::size_t kSamplesMax = 400'000;
constexpr int kGoodReaders = 2;

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

/// What a reader process tells its parent, in memory that both see.
struct ReaderResult {
  std::atomic<bool> ready;
  std::uint64_t packets;
  std::uint64_t missing;
  std::uint64_t heap_calls;
  std::uint32_t latency_ns[kSamplesMax];
};

template <typename T>
T* make_shared_memory() {
  void* memory = ::mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return new (memory) T{};
}

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
    const std::int64_t at_ns = now_ns();
    if (octets <= 0 || polhode_decode(packet, static_cast<std::size_t>(octets), POLHODE_MOTION, &motion, sizeof motion) != 0) {
      break;
    }
    if (motion.mode == POLHODE_MOTION_MODE_LOST) {  // the sender's last word
      break;
    }
    if (result.packets < kSamplesMax) {
      result.latency_ns[result.packets] = static_cast<std::uint32_t>(std::min<std::int64_t>(at_ns - motion.timestamp_ns, UINT32_MAX));
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
Reader start_reader(Read read) {
  Reader reader{.process = 0, .result = make_shared_memory<ReaderResult>()};
  reader.process = ::fork();
  if (reader.process == 0) {
    read(*reader.result);
    std::_Exit(0);
  }
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

Sent send_all(Transports& transports, int seconds, int rate) {
  Sent sent;
  const auto total = static_cast<std::uint64_t>(seconds) * static_cast<std::uint64_t>(rate);
  sent.send_ns.reserve(total);
  MotionState state;
  std::vector<std::uint8_t> octets(kMotionPacketOctets);
  const auto period = std::chrono::nanoseconds(1'000'000'000 / rate);
  auto due = Clock::now();
  const std::uint64_t before = heap_calls;
  for (std::uint64_t i = 0; i < total; ++i, due += period) {
    std::this_thread::sleep_until(due);
    state.frame = static_cast<std::uint32_t>(i);
    state.timestamp_ns = now_ns();
    (void)encode_motion(state, {}, static_cast<std::uint16_t>(i & 0x3FFF), octets);
    transports.send(octets);
    sent.send_ns.push_back(static_cast<std::uint32_t>(now_ns() - state.timestamp_ns));
    ++sent.packets;
  }
  sent.heap_calls = heap_calls - before;
  state.mode = Mode::kLost;
  (void)encode_motion(state, {}, static_cast<std::uint16_t>(total & 0x3FFF), octets);
  transports.send(octets);
  return sent;
}

double percentile_us(std::vector<std::uint32_t> values, double part) {
  if (values.empty()) {
    return 0.0;
  }
  std::sort(values.begin(), values.end());
  return 1e-3 * values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
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
    const std::int64_t now = now_ns();
    const std::uint32_t rung = bell.rung;
    if (rung != heard && result.packets < kSamplesMax) {
      result.latency_ns[result.packets++] = static_cast<std::uint32_t>(now - bell.at_ns[rung % Bell::kTimes]);
    }
    heard = rung;
  }
}

/// What waking two processes costs on this machine as it is loaded now.
void measure_waking(int seconds, int rate) {
  Bell* bell = make_shared_memory<Bell>();
  std::vector<Reader> readers;
  for (int i = 0; i < kGoodReaders; ++i) {
    readers.push_back(start_reader([bell](ReaderResult& result) { hear(*bell, result); }));
  }
  const auto total = static_cast<std::uint32_t>(seconds * rate);
  std::vector<std::uint32_t> waking_ns;
  auto due = Clock::now();
  for (std::uint32_t i = 1; i <= total; ++i, due += std::chrono::nanoseconds(1'000'000'000 / rate)) {
    std::this_thread::sleep_until(due);
    const std::int64_t before_ns = now_ns();
    bell->at_ns[i % Bell::kTimes] = before_ns;
    bell->over = i == total;
    bell->rung = i;
    ::syscall(SYS_futex, &bell->rung, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
    waking_ns.push_back(static_cast<std::uint32_t>(now_ns() - before_ns));
  }
  std::vector<std::uint32_t> latency;
  for (const Reader& reader : readers) {
    ::waitpid(reader.process, nullptr, 0);
    latency.insert(latency.end(), reader.result->latency_ns, reader.result->latency_ns + reader.result->packets);
  }
  fmt::print("{:<14} {:>8} {:>6} {:>9.1f} {:>9.1f} {:>9.1f}   {:>9.1f} {:>9.1f} {:>9.1f}\n", "(waking alone)", total, "", percentile_us(latency, 0.5),
             percentile_us(latency, 0.99), percentile_us(latency, 1.0), percentile_us(waking_ns, 0.5), percentile_us(waking_ns, 0.99),
             percentile_us(waking_ns, 1.0));
  std::fflush(stdout);
}

/// @return true when nothing was lost and no heap was used.
bool measure(const char* name, const std::vector<std::string>& addresses, int seconds, int rate) {
  // The shared-memory ring has to be there before its readers.
  const bool shared = addresses[0].starts_with("shm:");
  const std::vector<std::string> unique = shared ? std::vector{addresses[0]} : addresses;
  std::vector<Reader> readers;
  Transports early({.send = shared ? unique : std::vector<std::string>(), .receive = {}});
  for (const std::string& address : addresses) {
    readers.push_back(start_reader([&](ReaderResult& result) { read_all(address, result); }));
  }
  ::kill(readers.back().process, SIGSTOP);
  Transports later({.send = shared ? std::vector<std::string>() : unique, .receive = {}});
  const Sent sent = send_all(shared ? early : later, seconds, rate);
  bool good = sent.heap_calls == 0;
  std::vector<std::uint32_t> latency;
  std::uint64_t lost = 0;
  std::uint64_t heap = sent.heap_calls;
  for (int i = 0; i < kGoodReaders; ++i) {
    ::waitpid(readers[static_cast<std::size_t>(i)].process, nullptr, 0);
    const ReaderResult& result = *readers[static_cast<std::size_t>(i)].result;
    lost += sent.packets - result.packets;
    heap += result.heap_calls;
    latency.insert(latency.end(), result.latency_ns, result.latency_ns + std::min<std::uint64_t>(result.packets, kSamplesMax));
  }
  ::kill(readers.back().process, SIGKILL);
  ::waitpid(readers.back().process, nullptr, 0);
  good = good && lost == 0 && heap == 0;
  fmt::print("{:<14} {:>8} {:>6} {:>9.1f} {:>9.1f} {:>9.1f}   {:>9.1f} {:>9.1f} {:>9.1f} {:>6}\n", name, sent.packets, lost,
             percentile_us(latency, 0.5), percentile_us(latency, 0.99), percentile_us(latency, 1.0), percentile_us(sent.send_ns, 0.5),
             percentile_us(sent.send_ns, 0.99), percentile_us(sent.send_ns, 1.0), heap);
  std::fflush(stdout);
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  int seconds = 10;
  int rate = 1000;
  for (int i = 1; i + 1 < argc; i += 2) {
    (std::strcmp(argv[i], "--rate") == 0 ? rate : seconds) = std::atoi(argv[i + 1]);
  }
  char folder_name[] = "/tmp/polhode_latency_XXXXXX";
  const std::string folder = ::mkdtemp(folder_name);
  const std::string ring = fmt::format("shm:/polhode_latency_{}", ::getpid());
  fmt::print("{:<14} {:>8} {:>6} {:>29}   {:>29} {:>6}\n", "", "packets", "lost", "to a reader, us: p50 p99 max", "sending, us: p50 p99 max", "heap");
  bool good = true;
  measure_waking(seconds, rate);
  good = measure("unix datagram", {"unix:" + folder + "/a", "unix:" + folder + "/b", "unix:" + folder + "/stopped"}, seconds, rate) && good;
  good = measure("shared memory", {ring, ring, ring}, seconds, rate) && good;
  good = measure("udp loopback", {"udp:39301", "udp:39302", "udp:39303"}, seconds, rate) && good;
  ::shm_unlink(ring.c_str() + 4);
  (void)std::system(("rm -rf " + folder).c_str());
  return good ? 0 : 1;
}
