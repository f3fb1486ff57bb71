#include "transport/transports.hpp"

#include <fmt/format.h>

#include "base/assert.hpp"
#include "errors.hpp"

namespace polhode::platform {

Transports::Transports(const TransportSettings& settings, std::int64_t utc_ns)
    : ports_(settings.receive, settings.commands, static_cast<std::uint64_t>(utc_ns)) {
  senders_.reserve(settings.send.size());
  for (const std::string& text : settings.send) {
    named("transport.send", [&] { add_sender(text); });
  }
}

void Transports::add_sender(const std::string& text) {
  const Address address = parse_address(text);
  switch (address.kind) {
    case AddressKind::kUnix:
    case AddressKind::kUdp:
      senders_.push_back({text, DatagramSender(address, SenderName::kBesideReader)});
      break;
    case AddressKind::kShm:
      senders_.push_back({text, RingWriter(address)});
      break;
    case AddressKind::kFile:
      senders_.push_back({text, FlatFile(address)});
      break;
  }
}

void Transports::send(std::span<const std::uint8_t> packets) {
  for (std::size_t at = 0; at < packets.size();) {
    const std::span<const std::uint8_t> rest = packets.subspan(at);
    bus::PacketHeader header;
    const bool whole = bus::read_header(rest, header) && header.total_octets <= rest.size();
    POLHODE_ASSERT(whole, at);
    for (Sender& sender : senders_) {
      std::visit([&](auto& to) { to.send(rest.first(header.total_octets)); }, sender.to);
    }
    at += header.total_octets;
  }
}

void Transports::flush() {
  for (Sender& sender : senders_) {
    if (auto* datagrams = std::get_if<DatagramSender>(&sender.to)) {
      datagrams->flush();
    }
  }
}

std::span<const std::span<const std::uint8_t>> Transports::received() { return ports_.receive(); }

const SendCounts& Transports::counts(std::size_t number) const {
  return std::visit([](const auto& to) -> const SendCounts& { return to.counts(); },
                    senders_[number].to);
}

std::uint64_t Transports::refused_by_disk() const {
  std::uint64_t sum = 0;
  for (const Sender& sender : senders_) {
    const auto* file = std::get_if<FlatFile>(&sender.to);
    sum += file != nullptr ? file->refused() : 0;
  }
  return sum;
}

SendCounts Transports::counts() const {
  SendCounts sum;
  for (std::size_t i = 0; i < senders_.size(); ++i) {
    const SendCounts& one = counts(i);
    sum.sent += one.sent;
    sum.dropped += one.dropped;
    sum.no_reader += one.no_reader;
  }
  return sum;
}

}  // namespace polhode::platform
