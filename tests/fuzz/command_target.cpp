// The fuzz target: any octets as a command. What is taken must be whole by checks that are written
// here a second time, in another way.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>

#include "bus/commands.hpp"
#include "fuzz_counts.hpp"

namespace polhode::fuzz {

Counts& counts() {
  static Counts all;
  return all;
}

namespace {

constexpr int kApidFirst = 0x1A0;
// By function code, from the interface control document; of TABLE_LOAD without entries.
constexpr std::size_t kOctets[] = {10, 10, 10, 10, 10, 58, 26, 74, 14, 18, 18, 10, 10, 74};

[[noreturn]] void broken(const char* what) {
  std::fprintf(stderr, "command target: %s\n", what);
  std::abort();
}

/// CRC-16/CCITT-FALSE bit by bit.
unsigned checksum(std::span<const std::uint8_t> octets) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t octet : octets) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const unsigned in = octet >> (7U - bit) & 1U;
      const unsigned out = crc >> 15U & 1U;
      crc = (crc << 1U & 0xFFFFU) ^ (in != out ? 0x1021U : 0U);
    }
  }
  return crc;
}

void check_taken(std::span<const std::uint8_t> octets, const bus::Command& command) {
  const auto code = static_cast<std::size_t>(command.code);
  if (code >= std::size(kOctets) || octets[7] != code) {
    broken("an unknown code was taken");
  }
  if (octets.size() != kOctets[code] + 16 * command.entries ||
      octets[4] * 256U + octets[5] + 7U != octets.size()) {
    broken("a command of another length was taken");
  }
  if (octets[0] != 0x19 || octets[1] != 0xAF || octets[2] < 0xC0 ||
      octets[6] != bus::kLayoutVersion) {
    broken("a header that is not a command's was taken");
  }
  if (checksum(octets) != 0) {
    broken("a wrong checksum was taken");
  }
  if (command.code == bus::CommandCode::kSetRange) {
    const double range_m = command.arguments<bus::SetRangeCommand>().range_m;
    if (!(range_m >= 0.01 && range_m <= 100000.0)) {
      broken("a range out of range was taken");
    }
  }
  for (std::size_t i = 0; i < command.entries; ++i) {
    if (command.entry(i).index > 3 || command.entry(i).spare != 0) {
      broken("an entry out of range was taken");
    }
  }
}

void give(std::span<const std::uint8_t> octets) {
  bus::Command command;
  const bus::Refusal refusal = bus::read_command(octets, kApidFirst, &command);
  ++counts().given;
  if (refusal.reason == bus::Rejection::kNone) {
    ++counts().taken;
    check_taken(octets, command);
  } else {
    ++counts().refused[static_cast<std::size_t>(refusal.reason)];
  }
}

}  // namespace
}  // namespace polhode::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using polhode::bus::write_crc;
  const std::span<const std::uint8_t> octets(data, size);
  polhode::fuzz::give(octets);
  // A fuzzer does not guess checksums: the same octets with a right one reach what lies behind.
  static std::uint8_t sealed[polhode::limits::kPacketOctets + 1];
  if (size > 10 && size <= sizeof sealed) {
    std::memcpy(sealed, data, size);
    sealed[4] = static_cast<std::uint8_t>((size - 7) >> 8U);
    sealed[5] = static_cast<std::uint8_t>(size - 7);
    write_crc(std::span(sealed).first(size));
    polhode::fuzz::give(std::span(sealed).first(size));
  }
  return 0;
}
