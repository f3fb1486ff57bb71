#include "pipeline/bus_state.hpp"

namespace polhode {

BusRemembered remember(const BusState& bus) {
  return {.sequence = bus.stream.sequence,
          .event_counts = bus.events.counts,
          .event_window_begin = bus.events.window_begin,
          .events_sent = bus.events.sent,
          .events_suppressed = bus.events.suppressed,
          .packets_not_sent = bus.stream.not_sent,
          .commands = bus.commands,
          .table_crc = bus.table_crc,
          .cloud_number = bus.cloud.number,
          .held = bus.held,
          .servicer = bus.servicer,
          .told = bus.told};
}

void recall(const BusRemembered& remembered, BusState* bus) {
  bus->stream.sequence = remembered.sequence;
  bus->events.counts = remembered.event_counts;
  bus->events.window_begin = remembered.event_window_begin;
  bus->events.sent = remembered.events_sent;
  bus->events.suppressed = remembered.events_suppressed;
  bus->stream.not_sent = remembered.packets_not_sent;
  bus->commands = remembered.commands;
  bus->table_crc = remembered.table_crc;
  bus->cloud.number = remembered.cloud_number;
  bus->held = remembered.held;
  bus->servicer = remembered.servicer;
  bus->told = remembered.told;
  bus->told.started = false;
}

}  // namespace polhode
