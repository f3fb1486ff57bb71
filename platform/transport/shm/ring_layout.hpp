// The shared-memory ring: one writer, any number of readers, which it does not count.
//
// Packet n (from 0) lies in slot n modulo the number of slots. A slot's version is 2n + 1 while
// packet n is being written and 2n + 2 once it is whole. A reader copies the words one by one and
// looks at the version before and after: were they not both 2n + 2, the packet was overtaken, and
// is lost to this reader and to no other. Readers map the memory read-only and wait at the futex
// word.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "config/limits.hpp"

namespace polhode::platform::ring {

inline constexpr std::uint64_t kMagic = 0x31474E5248444C50;  // "PLDHRNG1", little-endian
inline constexpr std::size_t kSlots = 1024;                  // a second of 1000 packets
inline constexpr std::size_t kWords = (limits::kPacketOctets + 7) / 8;

struct alignas(64) Header {
  std::atomic<std::uint64_t> magic;  ///< written last: a reader that sees it may read on
  std::uint64_t slots;
  std::uint64_t slot_octets;
  std::uint64_t words;
  alignas(64) std::atomic<std::uint64_t> head;  ///< packets written so far
  std::atomic<std::uint32_t> futex;             ///< its low 32 bits
};

struct alignas(64) Slot {
  std::atomic<std::uint64_t> version;
  std::atomic<std::uint64_t> octets;
  std::atomic<std::uint64_t> words[kWords];
};

struct Ring {
  Header header;
  Slot slots[kSlots];
};

static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
static_assert(sizeof(Header) == 128 && sizeof(Slot) == 1472);

}  // namespace polhode::platform::ring
