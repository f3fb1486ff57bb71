#include "bus/events.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "bus/event_reports.hpp"

namespace polhode::bus::events_test {
namespace {

const BusOptions kOptions{.event_window_frames = 10};

std::uint32_t burst_of(EventId id) {
  const auto row =
      std::find_if(kEvents.begin(), kEvents.end(), [id](const EventRow& r) { return r.id == id; });
  return row->burst;
}

std::vector<EventPacket> sent_at(std::uint32_t frame, EventLog* log) {
  PacketStream stream;
  send_events(frame, 1000 * frame, kOptions, log, &stream);
  std::vector<EventPacket> packets;
  for (std::size_t at = 0; at < stream.size; at += event_layout::kPacketOctets) {
    EventPacket packet;
    EXPECT_TRUE(decode(EventPacket::layout(),
                       stream.view().subspan(at, event_layout::kPacketOctets),
                       &packet)
                    .ok());
    packets.push_back(packet);
  }
  return packets;
}

std::string text_of(const EventPacket& packet) { return {packet.text.data(), packet.text_octets}; }

TEST(EventTable, HasIdsThatDiffer_AndTextsThatFit) {
  std::set<EventId> ids;
  for (const EventRow& row : kEvents) {
    EXPECT_TRUE(ids.insert(row.id).second) << row.name;
    std::array<char, 256> out{};
    const double widest = -std::numeric_limits<double>::min() / 3.0;
    EXPECT_LE(
        event_text(
            row.text, {.values = {widest, widest}, .word = "a.parameter.with.a.long.name"}, out),
        122U)
        << row.name;
  }
}

TEST(EventText, PutsNumbersAndTheWordWhereTheTableSays) {
  EventLog log;
  event::command_range({.command = CommandCode::kSetKnownLength, .argument = "length_m"}, &log);
  event::scale_known({.metres_per_mu = 0.123456789, .relative_sigma = 1e-3, .number = "number 2"},
                     &log);
  const auto packets = sent_at(3, &log);
  ASSERT_EQ(packets.size(), 2U);
  EXPECT_EQ(text_of(packets[0]), "command 5 refused: length_m out of range");
  EXPECT_EQ(text_of(packets[1]),
            "scale known: 0.123457 m per map unit, relative sigma 0.001; number 2");
  EXPECT_EQ(packets[0].severity, static_cast<std::uint8_t>(Severity::kError));
  EXPECT_EQ(packets[0].frame, 3U);
  EXPECT_EQ(packets[0].timestamp_ns, 3000);
}

TEST(EventText, IsCutWhereItIsFull_AndHasNoControlCharacters) {
  EventLog log;
  const std::string longest(300, 'x');
  event::command_state({.command = CommandCode::kHold, .reason = longest}, &log);
  event::command_state({.command = CommandCode::kHold, .reason = "line\nbreak"}, &log);
  const auto packets = sent_at(0, &log);
  EXPECT_EQ(packets[0].text_octets, 122);
  EXPECT_EQ(text_of(packets[1]).find('\n'), std::string::npos);
}

TEST(EventText, NeverCarriesANumberThatIsNotFinite) {
  EventLog log;
  event::scale_known({.metres_per_mu = std::nan(""),
                      .relative_sigma = std::numeric_limits<double>::infinity(),
                      .number = ""},
                     &log);
  const auto packets = sent_at(0, &log);
  EXPECT_EQ(packets[0].value, (std::array<double, 2>{}));
}

TEST(EventThrottle, SendsABurstAndCountsTheRest) {
  EventLog log;
  for (int i = 0; i < 10; ++i) {
    event::frame_dark({}, &log);
  }
  const auto packets = sent_at(0, &log);
  ASSERT_EQ(packets.size(), burst_of(EventId::kFrameDark));
  EXPECT_EQ(packets.back().occurrences, burst_of(EventId::kFrameDark));
  EXPECT_EQ(log.suppressed, 10 - burst_of(EventId::kFrameDark));
  EXPECT_EQ(log.sent, burst_of(EventId::kFrameDark));
}

TEST(EventThrottle, LetsAPassOfCommandsBeAnsweredEach_AndLeavesRoomBesideAFlood) {
  EXPECT_GE(burst_of(EventId::kCommandAccepted), 2 * limits::kStepCommands);
  EXPECT_LT(burst_of(EventId::kCommandCrc) + limits::kStepCommands, limits::kStepEvents + 1);
}

TEST(EventThrottle, TellsOfWhatItHeldBack_WhenTheWindowEnds) {
  EventLog log;
  for (std::uint32_t i = 0; i < 10; ++i) {
    event::frame_dark({.frame = i, .bright_level = 0.0}, &log);
  }
  (void)sent_at(0, &log);
  EXPECT_TRUE(sent_at(9, &log).empty());
  const auto told = sent_at(10, &log);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].id, static_cast<std::uint16_t>(EventId::kFrameDark));
  EXPECT_EQ(told[0].suppressed, 10 - burst_of(EventId::kFrameDark));
  EXPECT_EQ(told[0].occurrences, 10U);
  EXPECT_EQ(told[0].value[0], 9.0) << "of the last one held back";
  EXPECT_TRUE(sent_at(20, &log).empty());
}

TEST(EventThrottle, OfOneKindHidesNoOther) {
  EventLog log;
  for (int frame = 0; frame < 5; ++frame) {
    for (int i = 0; i < 1000; ++i) {
      event::command_crc({}, &log);
    }
    event::target_lost({}, &log);
    const auto packets = sent_at(static_cast<std::uint32_t>(frame), &log);
    const auto lost = std::count_if(packets.begin(), packets.end(), [](const EventPacket& p) {
      return p.id == static_cast<std::uint16_t>(EventId::kTargetLost);
    });
    EXPECT_EQ(lost, frame < static_cast<int>(burst_of(EventId::kTargetLost)) ? 1 : 0) << frame;
  }
  EXPECT_EQ(log.sent + log.suppressed, 5U * 1001U);
}

TEST(EventThrottle, AStepsFullListLosesPacketsButNoCount) {
  EventLog log;
  for (const EventRow& row : kEvents) {
    log_event(row.id, {}, &log);
  }
  EXPECT_EQ(log.sent, limits::kStepEvents);
  EXPECT_EQ(log.suppressed, kEventKinds - limits::kStepEvents);
  std::uint32_t occurrences = 0;
  for (const EventCount& count : log.counts) {
    occurrences += count.occurrences;
  }
  EXPECT_EQ(occurrences, kEventKinds);
}

}  // namespace
}  // namespace polhode::bus::events_test
