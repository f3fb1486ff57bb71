#include "app/packet_printer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "app/packet_json.hpp"
#include "bus/event_table.hpp"
#include "bus/telemetry.hpp"
#include "errors.hpp"
#include "print_stderr.hpp"

namespace polhode::platform {
namespace {

/// Meaning of the codes among an event's numbers, "IDLE to ACQUIRING"; empty where there are none.
std::string event_words(const bus::Layout& layout, const void* packet) {
  if (&layout != &bus::EventPacket::layout()) {
    return "";
  }
  bus::EventPacket event;
  std::memcpy(static_cast<void*>(&event), packet, sizeof event);
  const auto row = std::find_if(bus::kEvents.begin(), bus::kEvents.end(), [&](const auto& known) {
    return known.id == bus::EventId{event.id};
  });
  std::string words;
  for (std::size_t i = 0; row != bus::kEvents.end() && i < row->words.size(); ++i) {
    if (!row->words[i].empty()) {
      const std::string_view word = bus::name_of(row->words[i], event.value[i]);
      words += words.empty() ? "" : " to ";
      words += word.empty() ? "unknown" : word;
    }
  }
  return words;
}

void print_packet(const bus::Layout& layout,
                  const bus::PacketHeader& header,
                  const void* packet,
                  bool json) {
  const std::string words = event_words(layout, packet);
  if (!json) {
    std::int64_t timestamp_ns = 0;  // every packet begins with it
    std::memcpy(&timestamp_ns, packet, sizeof timestamp_ns);
    fmt::print("{:>5} {:<12} {:>19} {}{}\n",
               header.sequence,
               layout.name,
               timestamp_ns,
               fields_text(layout, packet),
               words.empty() ? "" : fmt::format(" words=\"{}\"", words));
    return;
  }
  nlohmann::ordered_json out{
      {"packet", std::string(layout.name)}, {"apid", header.apid}, {"sequence", header.sequence}};
  out.update(fields_json(layout, packet));
  if (!words.empty()) {
    out["words"] = words;
  }
  fmt::print("{}\n", out.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

}  // namespace

void PacketPrinter::count_missing(const bus::PacketHeader& header) {
  const auto [last, first_of_apid] = last_sequence_.try_emplace(header.apid, header.sequence);
  if (!first_of_apid) {
    missing_ += bus::packets_missing(last->second, header.sequence);
    last->second = header.sequence;
  }
}

void PacketPrinter::packet(const bus::PacketHeader& header, std::span<const std::uint8_t> octets) {
  print_damage();
  if (packets_++ == 0 && !options_.json) {
    fmt::print("{:>5} {:<12} {:>19} {}\n", "count", "packet", "timestamp_ns", "fields");
  }
  count_missing(header);
  const bus::Layout* layout = bus::find_packet(header.apid, options_.apid_first);
  if (layout == nullptr) {
    ++unknown_[header.apid];
    return;
  }
  alignas(std::max_align_t) std::array<std::byte, bus::kStructOctetsMax> packet{};
  const Result<bus::PacketHeader> decoded = bus::decode(*layout, octets, packet.data());
  if (!decoded) {
    print_stderr("packet {} of APID {}: {}\n", packets_ - 1, header.apid, decoded.error().message);
    return;
  }
  print_packet(*layout, header, packet.data(), options_.json);
}

void PacketPrinter::damage(std::uint64_t offset, std::size_t octets) {
  if (damage_octets_ == 0) {
    damage_offset_ = offset;
  }
  damage_octets_ += octets;
  damaged_total_ += octets;
}

void PacketPrinter::finish() {
  print_damage();
  for (const auto& [apid, count] : unknown_) {
    print_stderr("{}: {} packets of APID {}, which is none of {} and following (--apid-first)\n",
                 options_.source,
                 count,
                 apid,
                 options_.apid_first);
  }
  if (idle_ + foreign_ > 0) {
    print_stderr("{}: passed over: {} idle packets, {} of other applications without our CRC\n",
                 options_.source,
                 idle_,
                 foreign_);
  }
  print_stderr("{} packets, {} missing by their counts, {} octets damaged\n",
               packets_,
               missing_,
               damaged_total_);
}

void PacketPrinter::print_damage() {
  if (damage_octets_ != 0) {
    print_stderr("{}: {} octets at offset {} are no packet\n",
                 options_.source,
                 damage_octets_,
                 damage_offset_);
    damage_octets_ = 0;
  }
}

void StreamReader::add(std::span<const std::uint8_t> more, bool at_end, PacketPrinter& printer) {
  buffered_.insert(buffered_.end(), more.begin(), more.end());
  std::size_t at = 0;
  while (at < buffered_.size()) {
    const bus::StreamPiece piece = bus::next_piece(
        buffered_, at, at_end, {.after_damage = after_damage_, .apid_first = printer.apid_first()});
    if (piece.kind == bus::PieceKind::kIncomplete) {
      break;
    }
    if (piece.kind == bus::PieceKind::kPacket) {
      printer.packet(piece.header, std::span(buffered_).subspan(piece.offset, piece.octets));
    } else if (piece.kind == bus::PieceKind::kDamaged) {
      printer.damage(offset_ + piece.offset, piece.octets);
    } else {
      printer.passed_over(piece.kind == bus::PieceKind::kIdle ? 1 : 0,
                          piece.kind == bus::PieceKind::kForeign ? 1 : 0);
    }
    after_damage_ = piece.kind == bus::PieceKind::kDamaged;
    at += piece.octets;
  }
  buffered_.erase(buffered_.begin(), buffered_.begin() + static_cast<std::ptrdiff_t>(at));
  offset_ += at;
}

}  // namespace polhode::platform
