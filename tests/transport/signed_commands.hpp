// A key of its own, and commands signed with it.
#pragma once

#include <fstream>
#include <string>

#include "packets.hpp"
#include "transport/command_guard.hpp"

namespace polhode::platform {

class SignedCommands {
 public:
  static constexpr std::uint64_t kUtc_ns = 1'700'000'000'000'000'000;

  explicit SignedCommands(char digit = 'a') {
    std::ofstream(key_file_) << std::string(2 * POLHODE_KEY_OCTETS, digit) << '\n';
    std::filesystem::permissions(key_file_, std::filesystem::perms::owner_read);
    key_ = read_key(key_file_);
  }

  [[nodiscard]] CommandSettings settings() const {
    return {.key = key_file_, .window = folder_ / "window", .unauthenticated = false};
  }
  [[nodiscard]] const polhode_key& key() const { return key_; }

  [[nodiscard]] Octets sign(Octets packet, std::uint64_t number) const {
    const std::size_t octets = packet.size();
    packet.resize(octets + POLHODE_TRAILER_OCTETS);
    EXPECT_EQ(polhode_sign(&key_, number, packet.data(), octets, packet.size()),
              static_cast<int>(packet.size()));
    return packet;
  }
  /// With the next number.
  Octets sign(const Octets& packet) { return sign(packet, ++last_); }
  [[nodiscard]] std::uint64_t last() const { return last_; }

 private:
  Folder folder_;
  std::string key_file_ = folder_ / "key";
  polhode_key key_{};
  std::uint64_t last_ = kUtc_ns;
};

}  // namespace polhode::platform
