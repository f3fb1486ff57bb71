#include "app/bus_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "bus/event_table.hpp"
#include "bus/telemetry.hpp"
#include "errors.hpp"

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

Clock::time_point after(double seconds) {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

bool answers_one_of(const BusAnswers::Commands& commands, int sequence) {
  constexpr int kCounts = bus::kSequenceModulus - 1;  // 0 is none
  const auto behind = static_cast<std::size_t>((sequence - commands.sequence + kCounts) % kCounts);
  return commands.sequence == 0 || (sequence != 0 && behind < commands.count);
}

BusReader open_to_wait(const std::string& address) {
  try {
    return open_bus_reader(address);
  } catch (const UnusableInput& problem) {
    throw UnusableInput(fmt::format("--wait {}", problem.what()));
  }
}

}  // namespace

BusAnswers::BusAnswers(const std::string& address, int apid_first)
    : address_(address), apid_first_(apid_first), bus_(open_to_wait(address)) {}

BusAnswers::Answer BusAnswers::read(std::span<const std::uint8_t> octets,
                                    const Commands& commands) {
  bus::PacketHeader header;
  (void)bus::read_header(octets, header);
  const bus::Layout* layout = bus::find_packet(header.apid, apid_first_);
  bus::CommandLinkPacket link;
  if (layout == &bus::CommandLinkPacket::layout() && bus::decode(*layout, octets, &link)) {
    (before_ ? last_ : before_) = link;
  }
  bus::EventPacket event;
  if (layout != &bus::EventPacket::layout() || !bus::decode(*layout, octets, &event) ||
      !closes_a_command(bus::EventId{event.id}) ||
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

std::span<const std::uint8_t> BusAnswers::next(Clock::time_point end) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
  if (left.count() <= 0) {
    return {};
  }
  const int octets =
      polhode_bus_next(bus_.get(), packet_.data(), packet_.size(), static_cast<int>(left.count()));
  if (octets < 0) {
    throw RunFailure(fmt::format("{}: {}", address_, std::generic_category().message(-octets)));
  }
  return std::span(packet_).first(static_cast<std::size_t>(octets));
}

void BusAnswers::begin(double timeout_s) {
  constexpr double kPeriod_s = 1.5;  // of the packet it is one, and a frame more
  const Clock::time_point end = after(std::min(timeout_s, kPeriod_s));
  while (!before_) {
    const std::span<const std::uint8_t> packet = next(end);
    if (packet.empty()) {
      return;
    }
    bus::PacketHeader header;
    (void)bus::read_header(packet, header);
    if (bus::find_packet(header.apid, apid_first_) == &bus::CommandLinkPacket::layout()) {
      (void)read(packet, {});
    }
  }
}

std::string BusAnswers::refused_at_ports() const {
  if (!before_ || !last_) {
    return {};
  }
  const std::pair<std::uint32_t, const char*> reasons[] = {
      {last_->refused_sender - before_->refused_sender, "sent by another user"},
      {last_->refused_form - before_->refused_form, "not signed (--key)"},
      {last_->refused_mac - before_->refused_mac, "signed by another key"},
      {last_->refused_number - before_->refused_number,
       "with a number that was taken or is too old (a clock that is behind)"}};
  std::string words;
  for (const auto& [count, reason] : reasons) {
    if (count > 0) {
      words += fmt::format("{}{} {}", words.empty() ? "" : ", ", count, reason);
    }
  }
  return words;
}

bool BusAnswers::all_refused(std::size_t commands) const {
  return before_ && last_ && last_->received - before_->received == commands &&
         last_->passed == before_->passed;
}

std::size_t BusAnswers::wait(const Commands& commands, double timeout_s) {
  const Clock::time_point end = after(timeout_s);
  std::size_t answered = 0;
  std::size_t refused = 0;
  while (answered < commands.count) {
    const std::span<const std::uint8_t> packet = next(end);
    const Answer answer = packet.empty() ? Answer{} : read(packet, commands);
    answered += answer.commands;
    refused += answer.refused ? answer.commands : 0;
    if (all_refused(commands.count)) {
      throw RunFailure(fmt::format("{}: {} of {} commands were refused at the port: {}",
                                   address_,
                                   commands.count,
                                   commands.count,
                                   refused_at_ports()));
    }
    if (packet.empty() && Clock::now() >= end) {
      const std::string words = refused_at_ports();
      throw RunFailure(fmt::format("{}: {} of {} commands were answered within {} s{}{}",
                                   address_,
                                   answered,
                                   commands.count,
                                   timeout_s,
                                   words.empty() ? "" : "; refused at the ports meanwhile: ",
                                   words));
    }
  }
  return refused;
}

}  // namespace polhode::platform
