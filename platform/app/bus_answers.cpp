#include "app/bus_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string_view>
#include <system_error>

#include "bus/event_table.hpp"
#include "bus/telemetry.hpp"
#include "errors.hpp"
#include "transport/client/c/polhode_bus.h"

namespace polhode::platform {
namespace {

using Clock = std::chrono::steady_clock;

/// With others of the same step, each command has one of these.
bool closes_a_command(bus::EventId id) {
  switch (id) {
    case bus::EventId::kNoop:
    case bus::EventId::kCountersReset:
    case bus::EventId::kCommandAccepted:
    case bus::EventId::kCommandRepeated:
    case bus::EventId::kCommandLength:
    case bus::EventId::kCommandHeader:
    case bus::EventId::kCommandCrc:
    case bus::EventId::kCommandUnknown:
    case bus::EventId::kCommandRange:
    case bus::EventId::kCommandState:
    case bus::EventId::kCommandTooMany:
      return true;
    default:
      return false;
  }
}

bool answers_one_of(const BusAnswers::Commands& commands, int sequence) {
  constexpr int kCounts = bus::kSequenceModulus - 1;  // 0 is none
  const auto behind = static_cast<std::size_t>((sequence - commands.sequence + kCounts) % kCounts);
  return commands.sequence == 0 || (sequence != 0 && behind < commands.count);
}

}  // namespace

void BusAnswers::Close::operator()(polhode_bus* bus) const {
  polhode_bus_close(bus);
  delete bus;
}

BusAnswers::BusAnswers(const std::string& address, int apid_first)
    : address_(address), apid_first_(apid_first), bus_(new polhode_bus{}) {
  const int failed = polhode_bus_open(bus_.get(), address.c_str());
  if (failed != 0) {
    throw UnusableInput(fmt::format(
        "--wait {}: cannot be opened: {}", address, std::generic_category().message(-failed)));
  }
}

BusAnswers::Answer BusAnswers::read(std::span<const std::uint8_t> octets,
                                    const Commands& commands) const {
  bus::PacketHeader header;
  (void)bus::read_header(octets, header);
  const bus::Layout& layout = bus::EventPacket::layout();
  bus::EventPacket event;
  if (bus::find_packet(header.apid, apid_first_) != &layout ||
      !bus::decode(layout, octets, &event) || !closes_a_command(bus::EventId{event.id}) ||
      !answers_one_of(commands, event.command_sequence)) {
    return {};
  }
  const bool refused = event.severity >= static_cast<std::uint8_t>(bus::Severity::kError);
  const std::size_t text_octets = std::min<std::size_t>(event.text_octets, event.text.size());
  fmt::print("frame {}: {}\n", event.frame, std::string_view(event.text.data(), text_octets));
  const bool many = bus::EventId{event.id} == bus::EventId::kCommandTooMany;
  return {.commands = many ? static_cast<std::size_t>(std::max(1.0, event.value[0])) : 1,
          .refused = refused};
}

std::size_t BusAnswers::wait(const Commands& commands, double timeout_s) {
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(timeout_s));
  std::array<std::uint8_t, POLHODE_PACKET_OCTETS_MAX> packet{};
  std::size_t answered = 0;
  std::size_t refused = 0;
  while (answered < commands.count) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) {
      throw RunFailure(fmt::format("{}: {} of {} commands were answered within {} s",
                                   address_,
                                   answered,
                                   commands.count,
                                   timeout_s));
    }
    const int octets =
        polhode_bus_next(bus_.get(), packet.data(), packet.size(), static_cast<int>(left.count()));
    if (octets < 0) {
      throw RunFailure(fmt::format("{}: {}", address_, std::generic_category().message(-octets)));
    }
    const Answer answer =
        octets == 0 ? Answer{}
                    : read(std::span(packet).first(static_cast<std::size_t>(octets)), commands);
    answered += answer.commands;
    refused += answer.refused ? answer.commands : 0;
  }
  return refused;
}

}  // namespace polhode::platform
