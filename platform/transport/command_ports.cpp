#include "transport/command_ports.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "errors.hpp"

namespace polhode::platform {

CommandPorts::CommandPorts(const std::vector<std::string>& addresses,
                           const CommandSettings& settings,
                           std::uint64_t utc_ns) {
  const std::string problem = problem_of(addresses, settings);
  if (!problem.empty()) {
    throw UnusableInput(problem);
  }
  if (addresses.size() > kPorts) {
    throw UnusableInput(fmt::format(
        "transport.receive: {} addresses, allowed are 0 .. {}", addresses.size(), kPorts));
  }
  ports_.reserve(addresses.size());
  for (const std::string& text : addresses) {
    named("transport.receive",
          [&] { ports_.push_back({.from = DatagramReceiver(parse_address(text))}); });
  }
  if (!ports_.empty()) {
    guard_ = CommandGuard(settings, utc_ns);
  }
}

/// The next command of this port. @return false: none waits, or enough was read.
bool CommandPorts::take_one(Port& port) {
  while (port.reads < kReads) {
    const std::span<std::uint8_t> place(octets_[count_]);
    const std::optional<Received> received = port.from.next(place);
    if (!received) {
      return false;
    }
    ++port.reads;
    if (const auto packet = guard_.pass(place.first(received->octets), *received)) {
      packets_[count_++] = *packet;
      return true;
    }
  }
  return false;
}

std::span<const std::span<const std::uint8_t>> CommandPorts::receive() {
  count_ = 0;
  for (Port& port : ports_) {
    port.reads = 0;
  }
  std::size_t empty = 0;  // ports in a row
  while (empty < ports_.size() && count_ < packets_.size()) {
    empty = take_one(ports_[first_]) ? 0 : empty + 1;
    first_ = (first_ + 1) % ports_.size();
  }
  guard_.keep_numbers();
  return std::span(packets_).first(count_);
}

std::uint32_t CommandPorts::dropped() const {
  std::uint32_t sum = 0;
  for (const Port& port : ports_) {
    sum += port.from.dropped();
  }
  return sum;
}

bool CommandPorts::open_to_all() const {
  return !guard_.has_key() && std::any_of(ports_.begin(), ports_.end(), [](const Port& port) {
    return !port.from.is_unix();
  });
}

}  // namespace polhode::platform
