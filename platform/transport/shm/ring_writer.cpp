#include "transport/shm/ring_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/futex.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstring>
#include <system_error>

#include "base/assert.hpp"
#include "errors.hpp"
#include "transport/shm/ring_layout.hpp"

namespace polhode::platform {
namespace {

using ring::Ring;

[[noreturn]] void refuse(const Address& address, const char* what) {
  throw UnusableInput(
      fmt::format("{}: {}: {}", address.text, what, std::generic_category().message(errno)));
}

int open_shared(const Address& address) {
  const int fd = ::shm_open(address.path.c_str(), O_RDWR | O_CREAT, S_IRUSR | S_IWUSR);
  if (fd < 0) {
    refuse(address, "cannot be made");
  }
  return fd;
}

Ring* map_ring(int fd, const Address& address) {
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    refuse(address, "another process writes there");
  }
  if (::fchmod(fd, S_IRUSR | S_IWUSR) != 0 || ::ftruncate(fd, sizeof(Ring)) != 0) {
    refuse(address, "cannot be sized");
  }
  void* memory =
      ::mmap(nullptr, sizeof(Ring), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd, 0);
  if (memory == MAP_FAILED) {
    refuse(address, "cannot be mapped");
  }
  return static_cast<Ring*>(memory);
}

bool is_whole(const ring::Header& header) {
  return header.magic.load(std::memory_order_acquire) == ring::kMagic &&
         header.slots == ring::kSlots && header.slot_octets == sizeof(ring::Slot) &&
         header.words == ring::kWords;
}

}  // namespace

RingWriter::RingWriter(const Address& address)
    : file_(open_shared(address)), ring_(map_ring(file_.get(), address)) {
  ring::Header& header = ring_->header;
  if (is_whole(header)) {
    return;  // what an earlier writer left
  }
  std::memset(static_cast<void*>(ring_), 0, sizeof(Ring));
  header.slots = ring::kSlots;
  header.slot_octets = sizeof(ring::Slot);
  header.words = ring::kWords;
  header.magic.store(ring::kMagic, std::memory_order_release);
}

RingWriter::~RingWriter() {
  if (ring_ != nullptr) {
    ::munmap(static_cast<void*>(ring_), sizeof(Ring));
  }
}

std::size_t RingWriter::octets() { return sizeof(Ring); }

void RingWriter::send(std::span<const std::uint8_t> packet) {
  POLHODE_ASSERT(packet.size() <= limits::kPacketOctets, packet.size());
  ring::Header& header = ring_->header;
  const std::uint64_t number = header.head.load(std::memory_order_relaxed);
  ring::Slot& slot = ring_->slots[number % ring::kSlots];
  slot.version.store(2 * number + 1, std::memory_order_relaxed);
  // A reader that sees one of the words below sees the odd version, too.
  std::atomic_thread_fence(std::memory_order_release);
  slot.octets.store(packet.size(), std::memory_order_relaxed);
  for (std::size_t at = 0, word = 0; at < packet.size(); at += 8, ++word) {
    std::uint64_t value = 0;
    std::memcpy(&value, &packet[at], std::min<std::size_t>(8, packet.size() - at));
    slot.words[word].store(value, std::memory_order_relaxed);
  }
  slot.version.store(2 * number + 2, std::memory_order_release);
  header.head.store(number + 1, std::memory_order_release);
  header.futex.store(static_cast<std::uint32_t>(number + 1), std::memory_order_release);
  ::syscall(SYS_futex, &header.futex, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
  ++counts_.sent;
}

}  // namespace polhode::platform
