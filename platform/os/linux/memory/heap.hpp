// A heap inside one block of memory: two-level segregated fit, so that every call takes constant
// time, however full or fragmented it is.
//
// Plain state without constructors: the process's own heap is needed before any constructor runs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace polhode::platform {

struct HeapUse {
  std::size_t total_bytes = 0;
  std::size_t used_bytes = 0;  ///< with the blocks' headers
  std::size_t peak_bytes = 0;
  std::size_t largest_free_bytes = 0;  ///< at least so much can be had in one piece
  std::size_t live_blocks = 0;
};

class Heap {
 public:
  static constexpr std::size_t kAlignment = 16;

  /// Takes over `memory`, aligned to 16 bytes and under 2^40 of them; its content is discarded.
  void open(std::span<std::byte> memory);
  [[nodiscard]] bool is_open() const { return first_ != nullptr; }
  [[nodiscard]] bool contains(const void* p) const;

  /// @param alignment a power of two.
  /// @return nullptr when no free block is large enough.
  void* allocate(std::size_t bytes, std::size_t alignment = kAlignment);
  /// @param p  from allocate, of this heap, not yet released; anything else aborts where it shows.
  void release(void* p);
  /// Bytes that the block may be used for.
  [[nodiscard]] static std::size_t usable_bytes(const void* p);
  /// Grows or shrinks in place. @return false, with nothing changed, when there is no room behind.
  bool resize(void* p, std::size_t bytes);

  [[nodiscard]] HeapUse use() const;
  void reset_peak() { peak_ = used_; }
  /// Walks all blocks. @return false when neighbours, sizes and free lists contradict each other.
  [[nodiscard]] bool consistent() const;

 private:
  struct Block;
  // 32 classes to each power of two: a block is at most 3 % larger than requested.
  static constexpr unsigned kSecondBits = 5;
  static constexpr unsigned kSeconds = 1U << kSecondBits;
  static constexpr unsigned kFirsts = 32;
  struct Place {
    unsigned first = 0;
    unsigned second = 0;
  };
  static Place place_of(std::size_t bytes);
  static std::size_t rounded(std::size_t bytes);
  Block* find(std::size_t bytes);
  void insert(Block* block);
  void remove(Block* block);
  Block* split(Block* block, std::size_t bytes);
  Block* merged(Block* block);
  void* take(Block* block, std::size_t bytes);

  Block* first_;
  std::byte* end_;
  std::uint32_t first_map_;
  std::array<std::uint32_t, kFirsts> second_map_;
  std::array<std::array<Block*, kSeconds>, kFirsts> free_;
  std::size_t used_;
  std::size_t peak_;
  std::size_t live_;
};

}  // namespace polhode::platform
