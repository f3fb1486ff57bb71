// The block that a component lives in.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <span>

#include "errors.hpp"

namespace polhode::platform {

class ComponentMemory {
 public:
  /// @throws RunFailure when there is not so much.
  explicit ComponentMemory(std::size_t octets)
      : octets_((octets + kAlignment - 1) / kAlignment * kAlignment),
        block_(static_cast<std::byte*>(std::aligned_alloc(kAlignment, octets_))) {
    if (!block_) {
      throw RunFailure(
          fmt::format("{} octets of memory for the component are not to be had", octets_));
    }
  }
  [[nodiscard]] std::span<std::byte> span() const { return {block_.get(), octets_}; }

 private:
  static constexpr std::size_t kAlignment = 64;
  struct Free {
    void operator()(std::byte* block) const { std::free(block); }
  };
  std::size_t octets_;
  std::unique_ptr<std::byte, Free> block_;
};

}  // namespace polhode::platform
