#include "transport/command_guard.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "bus/octets.hpp"
#include "errors.hpp"
#include "os/linux/file_faults.hpp"

namespace polhode::platform {
namespace {

constexpr std::size_t kLengthOctet = 4;  // of the primary header, CCSDS 133.0-B: total less 7
constexpr std::size_t kLengthOffset = 7;
constexpr std::size_t kShortest = 10;  // header, layout version, code, CRC

}  // namespace

polhode_key read_key(const std::filesystem::path& file) {
  polhode_key key{};
  const int failed = polhode_key_read(&key, file.c_str());
  if (failed == -EINVAL) {
    throw UnusableInput(fmt::format(
        "{}: allowed are 64 hexadecimal digits, as `openssl rand -hex 32` gives", file.string()));
  }
  if (failed == -EPERM) {
    throw UnusableInput(fmt::format(
        "{}: a key is a file of its own user's or root's, of mode 0600 or 0400", file.string()));
  }
  if (failed != 0) {
    fail_to_open(file, file.string() + ": cannot be read", -failed);
  }
  return key;
}

std::optional<polhode_key> key_of(const CommandSettings& settings) {
  if (settings.key.empty()) {
    return std::nullopt;
  }
  return named("commands.key", [&] { return read_key(settings.key); });
}

std::string problem_of(const std::vector<std::string>& receive, const CommandSettings& settings) {
  if (receive.empty()) {
    return {};
  }
  if (!settings.key.empty() && settings.window.empty()) {
    return "commands.window: missing; with commands.key it names the file that keeps the number "
           "of the last command over restarts";
  }
  if (!settings.key.empty() && settings.unauthenticated) {
    return "commands.unauthenticated = true: allowed is false with commands.key";
  }
  for (const std::string& address : receive) {
    const bool is_udp = address.starts_with("udp:");
    if (!is_udp && !address.starts_with("unix:")) {
      return fmt::format("transport.receive: '{}': allowed are unix:PATH and udp:", address);
    }
    if (is_udp && settings.key.empty() && !settings.unauthenticated) {
      return fmt::format(
          "transport.receive: '{}' would take commands from anybody: give commands.key, or "
          "commands.unauthenticated = true where all who reach it may command",
          address);
    }
  }
  return {};
}

CommandGuard::CommandGuard(const CommandSettings& settings, std::uint64_t utc_ns) {
  key_ = key_of(settings);
  if (!key_) {
    return;
  }
  named("commands.window",
        [&] { numbers_ = std::make_unique<NumberFile>(settings.window, *key_, utc_ns); });
  window_ = CommandWindow(numbers_->number());
}

std::optional<std::span<const std::uint8_t>> CommandGuard::pass(std::span<std::uint8_t> datagram,
                                                                const Received& received) {
  ++counts_.received;
  if (received.uid_known && received.uid != ::geteuid() && received.uid != 0) {
    ++counts_.refused_sender;
    return std::nullopt;
  }
  std::optional<std::span<const std::uint8_t>> packet = datagram;
  if (key_) {
    packet = take_trailer(datagram);
  }
  counts_.passed += packet ? 1 : 0;
  return packet;
}

void CommandGuard::keep_numbers() {
  if (late_.commands > 0 && numbers_->state_of(late_.number) != Kept::kYes) {
    counts_.numbers_not_kept += late_.commands;
  }
  late_ = {};
  if (passed_.commands == 0) {
    return;
  }
  const Kept kept = numbers_->keep(passed_.number);
  counts_.numbers_not_kept += kept == Kept::kRefused ? passed_.commands : 0;
  late_ = kept == Kept::kLate ? passed_ : Unkept{};
  passed_ = {};
}

std::optional<std::span<const std::uint8_t>> CommandGuard::take_trailer(
    std::span<std::uint8_t> datagram) {
  if (datagram.size() < kShortest + POLHODE_TRAILER_OCTETS ||
      bus::get_unsigned(datagram, kLengthOctet, 2) + kLengthOffset != datagram.size()) {
    ++counts_.refused_form;
    return std::nullopt;
  }
  const std::size_t signed_octets = datagram.size() - POLHODE_MAC_OCTETS;
  std::array<std::uint8_t, POLHODE_MAC_OCTETS> mac{};
  if (polhode_mac(&*key_, datagram.data(), signed_octets, mac.data()) != 0 ||
      CRYPTO_memcmp(mac.data(), &datagram[signed_octets], mac.size()) != 0) {
    ++counts_.refused_mac;
    return std::nullopt;
  }
  const std::size_t octets = datagram.size() - POLHODE_TRAILER_OCTETS;
  const std::uint64_t number = bus::get_unsigned(datagram, octets, POLHODE_NUMBER_OCTETS);
  if (!window_.is_new(number)) {
    ++counts_.refused_number;
    return std::nullopt;
  }
  window_.take(number);
  passed_ = {.commands = passed_.commands + 1, .number = window_.highest()};
  bus::put_unsigned(datagram, kLengthOctet, octets - kLengthOffset, 2);
  return datagram.first(octets);
}

}  // namespace polhode::platform
