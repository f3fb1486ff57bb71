// The process's memory: pools that are acquired once at start, and nothing after the seal.
//
// malloc_family.cpp makes the whole process, its libraries too, draw from here. The pool of an
// allocation is the calling thread's current one, that of a release follows from the address. A
// program without that file (sanitizer builds, unit tests of other parts) keeps the machine's heap;
// then pools stay empty and the seal is only a mark.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "os/linux/memory/heap.hpp"

namespace polhode::platform {

/// kGeneral: everything else. kStep: libraries called within step(). kJobs: those called by jobs.
/// kReserve: overflow of the others after the seal.
enum class Pool : std::uint8_t { kGeneral, kStep, kJobs, kReserve };
inline constexpr std::size_t kPoolCount = 4;
const char* pool_name(Pool pool);

using PoolBytes = std::array<std::size_t, kPoolCount>;

/// True when this program's malloc is the one here.
bool memory_is_fixed();

/// Acquires the pools, with every page present. Before this, and until the seal, all grows freely.
/// @throws RunFailure when the machine does not have it.
void open_pools(const PoolBytes& bytes);

/// From here on memory comes from the pools alone: overflow draws on the reserve, and when that is
/// exhausted the process ends by the hook.
void seal_memory();
/// For work that need not be bounded: the end of a replay.
void unseal_memory();
bool memory_is_sealed();

/// Sets the calling thread's pool as long as it lives.
class PoolScope {
 public:
  explicit PoolScope(Pool pool);
  ~PoolScope();
  PoolScope(const PoolScope&) = delete;
  PoolScope& operator=(const PoolScope&) = delete;
  PoolScope(PoolScope&&) = delete;
  PoolScope& operator=(PoolScope&&) = delete;

 private:
  Pool before_;
};

/// During its lifetime the calling thread's allocations lie outside of the pools, in memory of
/// their own: for large buffers with a row in the plan. Only before the seal; after it there are
/// the pools alone.
class BesideScope {
 public:
  BesideScope();
  ~BesideScope();
  BesideScope(const BesideScope&) = delete;
  BesideScope& operator=(const BesideScope&) = delete;
  BesideScope(BesideScope&&) = delete;
  BesideScope& operator=(BesideScope&&) = delete;

 private:
  bool before_;
};

/// Of one pool; for kGeneral with the memory that was handed out before the pools were opened.
HeapUse pool_use(Pool pool);
void reset_pool_peaks();
using PoolReport = std::array<HeapUse, kPoolCount>;
PoolReport report_pools();

/// Memory acquired beyond the pools while that was allowed.
std::size_t grown_bytes();

/// Allocations of this pool that had to draw on the reserve since the last call.
std::uint32_t take_overdrafts(Pool pool);

/// Called once when the reserve is exhausted too; must not return. The libraries do not survive a
/// null pointer (they crash, free twice, leak), so they never see one. Without a hook the process
/// reports it and ends with kMemoryExhausted.
using ExhaustionHook = void (*)(Pool pool, std::size_t bytes);
void set_exhaustion_hook(ExhaustionHook hook);
inline constexpr int kMemoryExhausted = 3;

/// Behind the malloc family. @return nullptr only before the seal, when the machine has no more.
void* region_allocate(std::size_t bytes, std::size_t alignment);
void region_release(void* p);
void* region_resize(void* p, std::size_t bytes);
std::size_t region_usable_bytes(const void* p);

/// Set by malloc_family.cpp.
void declare_memory_fixed();

}  // namespace polhode::platform
