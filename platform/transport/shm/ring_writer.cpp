#include "transport/shm/ring_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstring>

#include "base/assert.hpp"
#include "errors.hpp"
#include "os/linux/file_faults.hpp"
#include "os/linux/file_lock.hpp"
#include "os/linux/file_owner.hpp"
#include "transport/shm/ring_layout.hpp"

namespace polhode::platform {
namespace {

using ring::Ring;

constexpr mode_t kMode = S_IRUSR | S_IWUSR;
constexpr mode_t kOthers = S_IRWXG | S_IRWXO;

[[noreturn]] void refuse(const Address& address, const char* what) {
  fail_at_start(address.text + ": " + what, errno);
}

/// Does the name still refer to the opened memory, or has another process put its own there?
bool is_at_its_name(int fd, const Address& address) {
  const Descriptor now(::shm_open(address.path.c_str(), O_RDONLY, 0));
  struct stat opened {};
  struct stat named {};
  return now.get() >= 0 && ::fstat(fd, &opened) == 0 && ::fstat(now.get(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

/// Of this call's own making, or nothing: the name is taken.
Descriptor make_new(const Address& address) {
  Descriptor made(::shm_open(address.path.c_str(), O_RDWR | O_CREAT | O_EXCL, kMode));
  if (made.get() < 0 && errno != EEXIST) {
    refuse(address, "cannot be made");
  }
  return made;
}

/// The memory of that name; nothing: it has just gone. Another user's is not touched.
Descriptor open_present(const Address& address) {
  Descriptor present(::shm_open(address.path.c_str(), O_RDWR, 0));
  if (present.get() < 0 && errno != ENOENT) {
    fail_to_open("/dev/shm" + address.path, address.text + ": cannot be opened", errno);
  }
  const std::string problem = present.get() < 0 ? "" : problem_of_owner(present.get(), 0);
  if (!problem.empty()) {
    throw UnusableInput(fmt::format("{}: {}", address.text, problem));
  }
  return present;
}

Ring* map_ring(int fd, const Address& address) {
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

/// Continues the memory of an earlier writer of this user.
/// @return nullptr: it is of another size or layout, or was open to others, who may still have it.
Ring* take_over(int fd, const Address& address) {
  struct stat status {};
  if (!problem_of_owner(fd, kOthers).empty() || ::fstat(fd, &status) != 0 || status.st_nlink != 1 ||
      status.st_size != sizeof(Ring)) {
    return nullptr;
  }
  Ring* ring = map_ring(fd, address);
  if (is_whole(ring->header)) {
    return ring;
  }
  ::munmap(static_cast<void*>(ring), sizeof(Ring));
  return nullptr;
}

Ring* fill_new(int fd, const Address& address) {
  if (::fchmod(fd, kMode) != 0 || ::ftruncate(fd, sizeof(Ring)) != 0) {
    refuse(address, "cannot be sized");
  }
  Ring* ring = map_ring(fd, address);
  ring::Header& header = ring->header;
  header.slots = ring::kSlots;
  header.slot_octets = sizeof(ring::Slot);
  header.words = ring::kWords;
  header.magic.store(ring::kMagic, std::memory_order_release);
  return ring;
}

}  // namespace

RingWriter::RingWriter(const Address& address) {
  constexpr int kTries = 8;  // others may come and go between two calls
  for (int i = 0; i < kTries && ring_ == nullptr; ++i) {
    file_ = make_new(address);
    const bool is_new = file_.get() >= 0;
    if (!is_new) {
      file_ = open_present(address);
    }
    if (file_.get() < 0) {
      continue;
    }
    lock_file(file_.get(), address.text);
    if (!is_at_its_name(file_.get(), address)) {
      continue;
    }
    ring_ = is_new ? fill_new(file_.get(), address) : take_over(file_.get(), address);
    if (ring_ == nullptr) {
      ::shm_unlink(address.path.c_str());  // readers keep their mappings
    }
  }
  if (ring_ == nullptr) {
    throw UnusableInput(fmt::format("{}: others make and remove it", address.text));
  }
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
