// The block that a component's own tables live in.
#pragma once

#include <cstddef>
#include <span>

namespace polhode::platform {

/// Acquired from the machine whole, with every page present, and given back at the end.
class TableMemory {
 public:
  /// @throws RunFailure when the machine does not have it.
  explicit TableMemory(std::size_t bytes);
  ~TableMemory();
  TableMemory(const TableMemory&) = delete;
  TableMemory& operator=(const TableMemory&) = delete;
  TableMemory(TableMemory&&) = delete;
  TableMemory& operator=(TableMemory&&) = delete;

  [[nodiscard]] std::span<std::byte> span() const { return {data_, bytes_}; }

 private:
  std::size_t bytes_;
  std::byte* data_;
};

}  // namespace polhode::platform
