// Source: Masmano, Ripoll, Crespo and Real, TLSF: a new dynamic memory allocator for real-time
// systems, ECRTS 2004.
#include "os/linux/memory/heap.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <new>

namespace polhode::platform {

/// Lies before the memory that is handed out; a free block keeps its list in that memory.
struct Heap::Block {
  Block* before;  ///< neighbour in memory; nullptr for the first
  std::size_t size_and_free;

  static constexpr std::size_t kHeader = 16;
  static constexpr std::size_t kLeast = 16;  ///< room for the two links

  struct Links {
    Block* next;
    Block* previous;
  };

  [[nodiscard]] std::size_t size() const { return size_and_free & ~std::size_t{1}; }
  [[nodiscard]] bool is_free() const { return (size_and_free & 1U) != 0; }
  void set(std::size_t size, bool free) { size_and_free = size | (free ? 1U : 0U); }
  [[nodiscard]] std::byte* memory() { return reinterpret_cast<std::byte*>(this) + kHeader; }
  [[nodiscard]] Block* after() { return reinterpret_cast<Block*>(memory() + size()); }
  [[nodiscard]] Links& links() { return *reinterpret_cast<Links*>(memory()); }
  static Block* of(void* p) {
    return reinterpret_cast<Block*>(static_cast<std::byte*>(p) - kHeader);
  }
};

namespace {

constexpr std::size_t kMaxRequest = std::size_t{1} << 39;
// Below this every class is one size of 16 bytes' step.
constexpr std::size_t kSmall = 512;

std::size_t up_to(std::size_t value, std::size_t step) { return (value + step - 1) & ~(step - 1); }

}  // namespace

Heap::Place Heap::place_of(std::size_t bytes) {
  if (bytes < kSmall) {
    return {.first = 0, .second = static_cast<unsigned>(bytes / kAlignment)};
  }
  const auto log2 = static_cast<unsigned>(std::bit_width(bytes)) - 1;  // 9 and up
  return {.first = log2 - 8,
          .second = static_cast<unsigned>(bytes >> (log2 - kSecondBits)) - kSeconds};
}

/// Up to the next class boundary, so that every block of the class that is searched is large
/// enough.
std::size_t Heap::rounded(std::size_t bytes) {
  const std::size_t size = std::max(up_to(bytes, kAlignment), Block::kLeast);
  if (size < kSmall) {
    return size;
  }
  const auto log2 = static_cast<unsigned>(std::bit_width(size)) - 1;
  return up_to(size, std::size_t{1} << (log2 - kSecondBits));
}

void Heap::open(std::span<std::byte> memory) {
  *this = Heap{};
  const std::size_t usable = memory.size() / kAlignment * kAlignment;
  first_ = ::new (memory.data()) Block{};
  // The last header closes the row: never free, never handed out.
  end_ = memory.data() + usable;
  first_->set(usable - 2 * Block::kHeader, true);
  Block* last = ::new (static_cast<void*>(first_->after())) Block{};
  last->before = first_;
  last->set(0, false);
  insert(first_);
}

bool Heap::contains(const void* p) const {
  return p >= static_cast<const void*>(first_) && p < static_cast<const void*>(end_);
}

void Heap::insert(Block* block) {
  const Place at = place_of(block->size());
  Block*& head = free_[at.first][at.second];
  block->links() = {.next = head, .previous = nullptr};
  if (head != nullptr) {
    head->links().previous = block;
  }
  head = block;
  first_map_ |= 1U << at.first;
  second_map_[at.first] |= 1U << at.second;
}

void Heap::remove(Block* block) {
  const Place at = place_of(block->size());
  const Block::Links links = block->links();
  if (links.next != nullptr) {
    links.next->links().previous = links.previous;
  }
  if (links.previous != nullptr) {
    links.previous->links().next = links.next;
    return;
  }
  free_[at.first][at.second] = links.next;
  if (links.next == nullptr) {
    second_map_[at.first] &= ~(1U << at.second);
    if (second_map_[at.first] == 0) {
      first_map_ &= ~(1U << at.first);
    }
  }
}

/// The first block of the smallest class that surely holds `bytes` (a class boundary).
Heap::Block* Heap::find(std::size_t bytes) {
  Place at = place_of(bytes);
  std::uint32_t seconds = second_map_[at.first] & (~0U << at.second);
  if (seconds == 0) {
    const std::uint32_t firsts = at.first + 1 < kFirsts ? first_map_ & (~0U << (at.first + 1)) : 0U;
    if (firsts == 0) {
      return nullptr;
    }
    at.first = static_cast<unsigned>(std::countr_zero(firsts));
    seconds = second_map_[at.first];
  }
  return free_[at.first][static_cast<unsigned>(std::countr_zero(seconds))];
}

/// Cuts a block that is in no list; the rest behind `bytes` becomes free.
Heap::Block* Heap::split(Block* block, std::size_t bytes) {
  if (block->size() < bytes + Block::kHeader + Block::kLeast) {
    return block;
  }
  const std::size_t rest = block->size() - bytes - Block::kHeader;
  block->set(bytes, block->is_free());
  Block* behind = ::new (static_cast<void*>(block->after())) Block{};
  behind->before = block;
  behind->set(rest, true);
  behind->after()->before = behind;
  insert(merged(behind));
  return block;
}

/// Joins a block that is in no list with its free neighbours.
Heap::Block* Heap::merged(Block* block) {
  Block* after = block->after();
  if (after->is_free()) {
    remove(after);
    block->set(block->size() + Block::kHeader + after->size(), block->is_free());
    block->after()->before = block;
  }
  Block* before = block->before;
  if (before != nullptr && before->is_free()) {
    remove(before);
    before->set(before->size() + Block::kHeader + block->size(), true);
    before->after()->before = before;
    return before;
  }
  return block;
}

void* Heap::take(Block* block, std::size_t bytes) {
  block->set(block->size(), false);
  split(block, bytes);
  used_ += block->size() + Block::kHeader;
  peak_ = std::max(peak_, used_);
  ++live_;
  return block->memory();
}

void* Heap::allocate(std::size_t bytes, std::size_t alignment) {
  if (first_ == nullptr || bytes > kMaxRequest || alignment > kMaxRequest) {
    return nullptr;
  }
  const std::size_t size = rounded(bytes);
  const bool aligned = alignment <= kAlignment;
  // An aligned place lies somewhere in a block that is larger by the alignment and one header.
  Block* block = find(aligned ? size : rounded(size + alignment + Block::kHeader + Block::kLeast));
  if (block == nullptr) {
    return nullptr;
  }
  remove(block);
  if (aligned) {
    return take(block, size);
  }
  const auto start = reinterpret_cast<std::uintptr_t>(block->memory());
  std::uintptr_t place = up_to(start, alignment);
  if (place != start && place - start < Block::kHeader + Block::kLeast) {
    place = up_to(start + Block::kHeader + Block::kLeast, alignment);
  }
  if (place != start) {
    const std::size_t gap = place - start - Block::kHeader;
    const std::size_t rest = block->size() - gap - Block::kHeader;
    block->set(gap, true);
    Block* later = ::new (static_cast<void*>(block->after())) Block{};
    later->before = block;
    later->set(rest, false);
    later->after()->before = later;
    insert(block);
    block = later;
  }
  return take(block, size);
}

void Heap::release(void* p) {
  Block* block = Block::of(p);
  // Released twice, or written past its end: going on would hand memory out twice.
  if (block->is_free() || !contains(block) || block->after()->before != block) {
    std::abort();
  }
  used_ -= block->size() + Block::kHeader;
  --live_;
  block->set(block->size(), true);
  insert(merged(block));
}

std::size_t Heap::usable_bytes(const void* p) { return Block::of(const_cast<void*>(p))->size(); }

bool Heap::resize(void* p, std::size_t bytes) {
  Block* block = Block::of(p);
  const std::size_t size = rounded(bytes);
  const std::size_t held = block->size();
  Block* after = block->after();
  const std::size_t room = held + (after->is_free() ? after->size() + Block::kHeader : 0);
  if (bytes > kMaxRequest || room < size) {
    return false;
  }
  if (size > held) {
    remove(after);
    block->set(room, false);
    block->after()->before = block;
  }
  split(block, size);
  used_ = used_ - held + block->size();
  peak_ = std::max(peak_, used_);
  return true;
}

HeapUse Heap::use() const {
  HeapUse use{.total_bytes = static_cast<std::size_t>(end_ - reinterpret_cast<std::byte*>(first_)),
              .used_bytes = used_,
              .peak_bytes = peak_,
              .live_blocks = live_};
  if (first_map_ != 0) {
    const auto first = static_cast<unsigned>(std::bit_width(first_map_)) - 1;
    const auto second = static_cast<unsigned>(std::bit_width(second_map_[first])) - 1;
    use.largest_free_bytes = first == 0
                                 ? second * kAlignment
                                 : std::size_t{kSeconds + second} << (first + 8 - kSecondBits);
  }
  return use;
}

bool Heap::consistent() const {
  std::size_t used = 0;
  std::size_t live = 0;
  std::size_t free_blocks = 0;
  const Block* before = nullptr;
  Block* block = first_;
  for (; block->size() != 0; block = block->after()) {
    if (block->before != before || (before != nullptr && before->is_free() && block->is_free()) ||
        !contains(block->after())) {
      return false;
    }
    live += block->is_free() ? 0 : 1;
    used += block->is_free() ? 0 : block->size() + Block::kHeader;
    free_blocks += block->is_free() ? 1 : 0;
    before = block;
  }
  std::size_t listed = 0;
  for (unsigned first = 0; first < kFirsts; ++first) {
    for (unsigned second = 0; second < kSeconds; ++second) {
      for (Block* b = free_[first][second]; b != nullptr; b = b->links().next) {
        const Place at = place_of(b->size());
        if (!b->is_free() || at.first != first || at.second != second) {
          return false;
        }
        ++listed;
      }
    }
  }
  return block->before == before && used == used_ && live == live_ && listed == free_blocks;
}

}  // namespace polhode::platform
