// A vector whose capacity is part of its type. No heap; a full one refuses elements.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "base/assert.hpp"

namespace polhode {

template <typename T, std::size_t kCapacity>
class FixedVector {
 public:
  [[nodiscard]] static constexpr std::size_t capacity() { return kCapacity; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] bool full() const { return size_ == kCapacity; }

  /// @return false, with nothing changed, when full.
  [[nodiscard]] bool push_back(const T& value) {
    if (full()) {
      return false;
    }
    items_[size_++] = value;
    return true;
  }
  void pop_back() {
    POLHODE_ASSERT(size_ > 0, size_);
    --size_;
  }
  /// Removes an element; the order of the rest stays.
  void erase(std::size_t index) {
    POLHODE_ASSERT(index < size_, index);
    for (std::size_t i = index + 1; i < size_; ++i) {
      items_[i - 1] = items_[i];
    }
    --size_;
  }
  void clear() { size_ = 0; }
  void resize(std::size_t size) {
    POLHODE_ASSERT(size <= kCapacity, size);
    for (std::size_t i = size_; i < size; ++i) {
      items_[i] = T{};
    }
    size_ = size;
  }

  T& operator[](std::size_t index) {
    POLHODE_ASSERT(index < size_, index);
    return items_[index];
  }
  const T& operator[](std::size_t index) const {
    POLHODE_ASSERT(index < size_, index);
    return items_[index];
  }
  T& back() { return (*this)[size_ - 1]; }
  const T& back() const { return (*this)[size_ - 1]; }

  T* begin() { return items_.data(); }
  T* end() { return items_.data() + size_; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }
  [[nodiscard]] std::span<const T> view() const { return {items_.data(), size_}; }
  [[nodiscard]] std::span<T> view() { return {items_.data(), size_}; }

 private:
  std::array<T, kCapacity> items_{};
  std::size_t size_ = 0;
};

}  // namespace polhode
