#include "app/bus_follow.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <system_error>
#include <thread>

#include "app/bus_answers.hpp"
#include "app/bus_reader.hpp"
#include "app/command_check.hpp"
#include "app/packet_printer.hpp"
#include "bus/repeated_commands.hpp"
#include "errors.hpp"
#include "print_stderr.hpp"
#include "transport/client/c/polhode_bus.h"
#include "transport/command_guard.hpp"
#include "transport/command_text.hpp"
#include "transport/datagram/datagram.hpp"

namespace polhode::platform {
namespace {

constexpr int kPacketWait_ms = 200;  // after which an interruption is seen

volatile std::sig_atomic_t interrupted = 0;

/// Reports damage that the reader skipped since the last call.
void print_loss(const polhode_bus& bus, std::uint64_t& damaged, std::uint64_t& overrun) {
  if (bus.damaged_octets != damaged) {
    print_stderr("{} octets were no packet\n", bus.damaged_octets - damaged);
    damaged = bus.damaged_octets;
  }
  if (bus.overrun != overrun) {
    print_stderr("{} packets were overwritten before they were read\n", bus.overrun - overrun);
    overrun = bus.overrun;
  }
}

/// Each with the next number.
/// @param number  of the first; 0: the time.
void sign(const polhode_key& key,
          std::uint64_t number,
          std::vector<std::vector<std::uint8_t>>& packets) {
  std::uint64_t last = 0;
  for (auto& packet : packets) {
    const std::uint64_t next = number > 0 ? number++ : polhode_next_number(last);
    const std::size_t octets = packet.size();
    packet.resize(octets + POLHODE_TRAILER_OCTETS);
    if (polhode_sign(&key, next, packet.data(), octets, packet.size()) < 0) {
      throw UnusableInput("--key: a command that is no packet is not signed");
    }
    last = next;
  }
}

}  // namespace

void follow_bus(const BusFollowArguments& arguments) {
  const Address address = parse_address(arguments.address);
  const BusReader bus = open_bus_reader(address.text);
  bus->apid_first = arguments.apid_first;
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  PacketPrinter printer(
      {.source = address.text, .json = arguments.json, .apid_first = arguments.apid_first});
  std::array<std::uint8_t, POLHODE_PACKET_OCTETS_MAX> packet{};
  std::uint64_t damaged = 0;
  std::uint64_t overrun = 0;
  double waited_s = 0.0;
  while (interrupted == 0) {
    const int octets = polhode_bus_next(bus.get(), packet.data(), packet.size(), kPacketWait_ms);
    print_loss(*bus, damaged, overrun);
    if (octets < 0) {
      throw RunFailure(
          fmt::format("{}: {}", address.text, std::generic_category().message(-octets)));
    }
    waited_s = octets == 0 ? waited_s + 1e-3 * kPacketWait_ms : 0.0;
    if (octets > 0) {
      const auto view = std::span(packet).first(static_cast<std::size_t>(octets));
      bus::PacketHeader header;
      (void)bus::read_header(view, header);
      printer.packet(header, view);
      std::fflush(stdout);
    }
    if ((arguments.count > 0 && printer.packets() >= static_cast<std::uint64_t>(arguments.count)) ||
        (arguments.timeout_s > 0.0 && waited_s >= arguments.timeout_s)) {
      break;
    }
  }
  printer.count_damage(bus->damaged_octets);
  printer.passed_over(bus->idle, bus->foreign);
  printer.finish();
}

namespace {

std::vector<std::vector<std::uint8_t>> command_packets(const BusSendArguments& arguments) {
  CommandWriter writer(arguments.apid_first);
  writer.count_from(static_cast<std::uint16_t>(arguments.sequence));
  std::vector<std::vector<std::uint8_t>> packets;
  std::string line;
  const auto end_line = [&] {
    packets.push_back(writer.packet(line));
    if (!line.starts_with("hex")) {  // octets are sent as they are
      check_ranges(packets.back(), arguments.apid_first);
    }
    line.clear();
  };
  for (const std::string& word : arguments.words) {
    if (word == "+") {
      end_line();
    } else {
      line += (line.empty() ? "" : " ") + word;
    }
  }
  end_line();
  return packets;
}

/// Signed where there is a key; none too long for the way.
void finish_packets(const BusSendArguments& arguments,
                    std::vector<std::vector<std::uint8_t>>* packets) {
  if (!arguments.key.empty()) {
    sign(read_key(arguments.key), arguments.number, *packets);
  }
  for (const auto& packet : *packets) {
    if (packet.size() > limits::kPacketOctets) {
      throw UnusableInput(fmt::format(
          "a command of {} octets: allowed are {}", packet.size(), limits::kPacketOctets));
    }
  }
}

/// @throws RunFailure: nobody takes them, or the receiver's queue stays full.
void send_packets(const Address& address, const std::vector<std::vector<std::uint8_t>>& packets) {
  DatagramSender sender(address);
  if (address.kind == AddressKind::kUdp) {
    sender.hear_refusals();
  }
  for (const auto& packet : packets) {
    sender.send(packet);
  }
  // A receiver takes its commands with its next frame; until then its queue may be full.
  constexpr int kTries = 200;
  constexpr std::chrono::milliseconds kPause{10};
  const SendCounts& counts = sender.counts();
  for (int i = 0; i < kTries && counts.sent + counts.no_reader < packets.size(); ++i) {
    std::this_thread::sleep_for(kPause);
    sender.flush();
  }
  // The refusal of this machine comes at once, that of another one within a round trip.
  constexpr int kRefusal_ms = 100;
  const bool refused = address.kind == AddressKind::kUdp && sender.refused(kRefusal_ms);
  if (counts.no_reader > 0 || refused) {
    throw RunFailure(fmt::format("{}: nobody takes commands there", address.text));
  }
  if (counts.sent != packets.size()) {
    throw RunFailure(
        fmt::format("{}: {} of {} commands were sent, then the receiver's queue stayed full",
                    address.text,
                    counts.sent,
                    packets.size()));
  }
}

}  // namespace

void send_command(const BusSendArguments& arguments) {
  const Address address = parse_address(arguments.address);
  if (address.kind != AddressKind::kUnix && address.kind != AddressKind::kUdp) {
    throw UnusableInput(fmt::format("{}: allowed are unix: and udp:", arguments.address));
  }
  auto packets = command_packets(arguments);
  BusAnswers::Sequences sequences;
  for (const auto& packet : packets) {
    sequences.push_back(bus::answered_sequence(packet));
  }
  finish_packets(arguments, &packets);
  std::optional<BusAnswers> answers;
  if (!arguments.wait.empty()) {
    answers.emplace(parse_address(arguments.wait).text, arguments.apid_first);
    answers->begin(arguments.timeout_s);
  }
  send_packets(address, packets);
  if (answers) {
    const std::size_t refused = answers->wait(sequences, arguments.timeout_s);
    if (refused > 0) {
      throw RunFailure(fmt::format(
          "{}: {} of {} commands were refused", arguments.address, refused, packets.size()));
    }
  }
}

}  // namespace polhode::platform
