// Which numbered commands have been taken already.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace polhode::platform {

/// The greatest numbers taken. Numbers need not follow each other: signers use the time. A number
/// is taken once, and none below the window.
class CommandWindow {
 public:
  /// Datagrams that overtake each other by less than this are all taken: the least anti-replay
  /// window of RFC 4303.
  static constexpr std::size_t kNumbers = 32;

  /// @param floor  no number up to this one is taken.
  explicit CommandWindow(std::uint64_t floor = 0) : floor_(floor), highest_(floor) {}

  [[nodiscard]] bool is_new(std::uint64_t number) const;
  /// @param number  a new one.
  void take(std::uint64_t number);
  /// Of those taken, or the floor.
  [[nodiscard]] std::uint64_t highest() const { return highest_; }

 private:
  [[nodiscard]] std::span<const std::uint64_t> taken() const {
    return std::span(taken_).first(count_);
  }

  std::array<std::uint64_t, kNumbers> taken_{};
  std::size_t count_ = 0;
  std::uint64_t floor_;
  std::uint64_t highest_;
};

}  // namespace polhode::platform
