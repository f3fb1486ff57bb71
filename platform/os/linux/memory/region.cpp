#include "os/linux/memory/region.hpp"

#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>

#include "errors.hpp"
#include "os/linux/last_words.hpp"

namespace polhode::platform {
namespace {

constexpr std::size_t kEarlyBytes = std::size_t{8} << 20;  // constructors of the shared libraries
constexpr std::size_t kGrowthBytes = std::size_t{16} << 20;
constexpr std::size_t kGrowthsMax = 256;

/// A heap that threads may share. The lock passes on the priority of waiting threads.
struct Area {
  Heap heap;
  pthread_mutex_t mutex;
};

// All of this is zero before any constructor runs, and is used before.
alignas(64) std::byte g_early_memory[kEarlyBytes];
Area g_early;
Area g_pools[kPoolCount];
Area g_growths[kGrowthsMax];
std::atomic<std::size_t> g_growth_count;
pthread_mutex_t g_growth_mutex = PTHREAD_MUTEX_INITIALIZER;
std::atomic<std::uint32_t> g_overdrafts[kPoolCount];
std::atomic<bool> g_sealed;
std::atomic<ExhaustionHook> g_hook;
bool g_fixed;
thread_local constinit Pool g_pool = Pool::kGeneral;
thread_local constinit bool g_beside = false;

void open(Area* area, std::span<std::byte> memory) {
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
  pthread_mutex_init(&area->mutex, &attributes);
  pthread_mutexattr_destroy(&attributes);
  area->heap.open(memory);
}

void* allocate(Area* area, std::size_t bytes, std::size_t alignment) {
  if (!area->heap.is_open()) {
    return nullptr;
  }
  pthread_mutex_lock(&area->mutex);
  void* p = area->heap.allocate(bytes, alignment);
  pthread_mutex_unlock(&area->mutex);
  return p;
}

Area* area_of(const void* p) {
  for (Area& area : g_pools) {
    if (area.heap.contains(p)) {
      return &area;
    }
  }
  if (g_early.heap.contains(p)) {
    return &g_early;
  }
  for (std::size_t i = 0; i < g_growth_count.load(std::memory_order_acquire); ++i) {
    if (g_growths[i].heap.contains(p)) {
      return &g_growths[i];
    }
  }
  // Memory that is not ours was never handed out here: releasing it is a mistake.
  std::abort();
}

void* map_bytes(std::size_t bytes, bool present) {
  void* p = ::mmap(nullptr,
                   bytes,
                   PROT_READ | PROT_WRITE,
                   MAP_PRIVATE | MAP_ANONYMOUS | (present ? MAP_POPULATE : 0),
                   -1,
                   0);
  return p == MAP_FAILED ? nullptr : p;
}

/// Another area, while that is allowed.
void* grow_and_allocate(std::size_t bytes, std::size_t alignment) {
  pthread_mutex_lock(&g_growth_mutex);
  void* p = nullptr;
  const std::size_t count = g_growth_count.load(std::memory_order_relaxed);
  for (std::size_t i = count; i > 0 && p == nullptr; --i) {
    p = allocate(&g_growths[i - 1], bytes, alignment);
  }
  if (p == nullptr && count < kGrowthsMax && bytes < (std::size_t{1} << 38)) {
    // Room for the block's own rounding, its alignment and the headers at both ends.
    const std::size_t need = bytes + bytes / 16 + 2 * alignment + 4096;
    const std::size_t size = (std::max(need, kGrowthBytes) + 4095) / 4096 * 4096;
    if (void* memory = map_bytes(size, false)) {
      open(&g_growths[count], {static_cast<std::byte*>(memory), size});
      g_growth_count.store(count + 1, std::memory_order_release);
      p = allocate(&g_growths[count], bytes, alignment);
    }
  }
  pthread_mutex_unlock(&g_growth_mutex);
  return p;
}

[[noreturn]] void exhausted(Pool pool, std::size_t bytes) {
  if (const ExhaustionHook hook = g_hook.load()) {
    hook(pool, bytes);
  }
  print_last(
      "polhode: memory is exhausted, the reserve too: %zu octets were asked of the pool '%s'; the "
      "run ends here\n",
      bytes,
      pool_name(pool));
  ::_exit(kMemoryExhausted);
}

void* overflow(Pool pool, std::size_t bytes, std::size_t alignment) {
  g_overdrafts[static_cast<std::size_t>(pool)].fetch_add(1, std::memory_order_relaxed);
  void* p = allocate(&g_pools[static_cast<std::size_t>(Pool::kReserve)], bytes, alignment);
  if (p == nullptr) {
    exhausted(pool, bytes);
  }
  return p;
}

}  // namespace

const char* pool_name(Pool pool) {
  switch (pool) {
    case Pool::kGeneral:
      return "general";
    case Pool::kStep:
      return "step";
    case Pool::kJobs:
      return "jobs";
    case Pool::kReserve:
      return "reserve";
  }
  return "";
}

void declare_memory_fixed() { g_fixed = true; }
bool memory_is_fixed() { return g_fixed; }
bool memory_is_sealed() { return g_sealed.load(); }
void seal_memory() { g_sealed.store(true); }
void unseal_memory() { g_sealed.store(false); }
void set_exhaustion_hook(ExhaustionHook hook) { g_hook.store(hook); }

void open_pools(const PoolBytes& bytes) {
  if (!g_fixed) {
    return;
  }
  for (std::size_t i = 0; i < kPoolCount; ++i) {
    const std::size_t size = (bytes[i] + 4095) / 4096 * 4096;
    if (size == 0 || g_pools[i].heap.is_open()) {
      continue;
    }
    void* memory = map_bytes(size, true);
    if (memory == nullptr) {
      throw RunFailure(std::string("memory for the pool '") + pool_name(static_cast<Pool>(i)) +
                       "' is not to be had: " + std::to_string(size) + " octets");
    }
    open(&g_pools[i], {static_cast<std::byte*>(memory), size});
  }
}

PoolScope::PoolScope(Pool pool) : before_(g_pool) { g_pool = pool; }
PoolScope::~PoolScope() { g_pool = before_; }

BesideScope::BesideScope() : before_(g_beside) { g_beside = true; }
BesideScope::~BesideScope() { g_beside = before_; }

HeapUse pool_use(Pool pool) {
  const Area& area = g_pools[static_cast<std::size_t>(pool)];
  HeapUse use = area.heap.is_open() ? area.heap.use() : HeapUse{};
  if (pool == Pool::kGeneral && g_early.heap.is_open()) {
    const HeapUse early = g_early.heap.use();
    use.total_bytes += early.total_bytes;
    use.used_bytes += early.used_bytes;
    use.peak_bytes += early.peak_bytes;
    use.live_blocks += early.live_blocks;
  }
  return use;
}

PoolReport report_pools() {
  PoolReport report;
  for (std::size_t i = 0; i < kPoolCount; ++i) {
    report[i] = pool_use(static_cast<Pool>(i));
  }
  return report;
}

void reset_pool_peaks() {
  for (Area& area : g_pools) {
    if (area.heap.is_open()) {
      area.heap.reset_peak();
    }
  }
}

std::size_t grown_bytes() {
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < g_growth_count.load(std::memory_order_acquire); ++i) {
    bytes += g_growths[i].heap.use().total_bytes;
  }
  return bytes;
}

std::uint32_t take_overdrafts(Pool pool) {
  return g_overdrafts[static_cast<std::size_t>(pool)].exchange(0);
}

void* region_allocate(std::size_t bytes, std::size_t alignment) {
  if (!g_early.heap.is_open()) {  // the first call of all, before there are threads
    open(&g_early, g_early_memory);
  }
  const Pool pool = g_pool;
  const bool sealed = g_sealed.load(std::memory_order_relaxed);
  if (g_beside && !sealed) {
    return grow_and_allocate(bytes, alignment);
  }
  if (void* p = allocate(&g_pools[static_cast<std::size_t>(pool)], bytes, alignment)) {
    return p;
  }
  if (pool == Pool::kGeneral) {
    if (void* p = allocate(&g_early, bytes, alignment)) {
      return p;
    }
  }
  return sealed ? overflow(pool, bytes, alignment) : grow_and_allocate(bytes, alignment);
}

void region_release(void* p) {
  Area* area = area_of(p);
  pthread_mutex_lock(&area->mutex);
  area->heap.release(p);
  pthread_mutex_unlock(&area->mutex);
}

std::size_t region_usable_bytes(const void* p) { return Heap::usable_bytes(p); }

void* region_resize(void* p, std::size_t bytes) {
  Area* area = area_of(p);
  pthread_mutex_lock(&area->mutex);
  const bool in_place = area->heap.resize(p, bytes);
  pthread_mutex_unlock(&area->mutex);
  if (in_place) {
    return p;
  }
  void* moved = region_allocate(bytes, Heap::kAlignment);
  if (moved != nullptr) {
    std::memcpy(moved, p, std::min(bytes, Heap::usable_bytes(p)));
    region_release(p);
  }
  return moved;
}

}  // namespace polhode::platform
