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

/// @return how many there were, `count` at most.
std::size_t take(std::uint16_t sequence, std::size_t count, BusAnswers::Sequences* waiting) {
  std::size_t taken = 0;
  while (taken < count) {
    const auto at = std::find(waiting->begin(), waiting->end(), sequence);
    if (at == waiting->end()) {
      break;
    }
    waiting->erase(at);
    ++taken;
  }
  return taken;
}

BusReader open_to_wait(const std::string& address) {
  return named("--wait", [&] { return open_bus_reader(address); });
}

}  // namespace

BusAnswers::BusAnswers(const std::string& address, int apid_first)
    : address_(address), apid_first_(apid_first), bus_(open_to_wait(address)) {}

std::size_t BusAnswers::read(std::span<const std::uint8_t> octets, Sequences* waiting) {
  bus::PacketHeader header;
  (void)bus::read_header(octets, header);
  const bus::Layout* layout = bus::find_packet(header.apid, apid_first_);
  bus::CommandLinkPacket link;
  if (layout == &bus::CommandLinkPacket::layout() && bus::decode(*layout, octets, &link)) {
    (before_ ? last_ : before_) = link;
  }
  bus::EventPacket event;
  if (layout != &bus::EventPacket::layout() || !bus::decode(*layout, octets, &event) ||
      !closes_a_command(bus::EventId{event.id})) {
    return 0;
  }
  const bool many = bus::EventId{event.id} == bus::EventId::kCommandTooMany;
  const std::size_t answered =
      take(event.command_sequence,
           many ? static_cast<std::size_t>(std::max(1.0, event.value[0])) : 1,
           waiting);
  if (answered > 0) {
    const std::size_t text_octets = std::min<std::size_t>(event.text_octets, event.text.size());
    fmt::print("frame {}: {}\n", event.frame, std::string_view(event.text.data(), text_octets));
  }
  const bool refused = event.severity >= static_cast<std::uint8_t>(bus::Severity::kError);
  return refused ? answered : 0;
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
  polhode_bus_to_end(bus_.get());
  Sequences none;
  const Clock::time_point end = after(std::min(timeout_s, kPeriod_s));
  while (!before_) {
    const std::span<const std::uint8_t> packet = next(end);
    if (packet.empty()) {
      return;
    }
    bus::PacketHeader header;
    (void)bus::read_header(packet, header);
    if (bus::find_packet(header.apid, apid_first_) == &bus::CommandLinkPacket::layout()) {
      (void)read(packet, &none);
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

std::size_t BusAnswers::wait(const Sequences& commands, double timeout_s) {
  const Clock::time_point end = after(timeout_s);
  Sequences waiting = commands;
  std::size_t refused = 0;
  while (!waiting.empty()) {
    const std::span<const std::uint8_t> packet = next(end);
    refused += packet.empty() ? 0 : read(packet, &waiting);
    if (all_refused(commands.size())) {
      throw RunFailure(fmt::format("{}: {} of {} commands were refused at the port: {}",
                                   address_,
                                   commands.size(),
                                   commands.size(),
                                   refused_at_ports()));
    }
    if (packet.empty() && Clock::now() >= end) {
      const std::string words = refused_at_ports();
      throw RunFailure(fmt::format("{}: {} of {} commands were answered within {} s{}{}",
                                   address_,
                                   commands.size() - waiting.size(),
                                   commands.size(),
                                   timeout_s,
                                   words.empty() ? "" : "; refused at the ports meanwhile: ",
                                   words));
    }
  }
  return refused;
}

}  // namespace polhode::platform
