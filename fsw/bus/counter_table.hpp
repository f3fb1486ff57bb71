// Written by tools/generate_bus.py from config/bus/*.toml: change those.
// Every counter by its name, and where it stands in the housekeeping packet.
#pragma once

#include <array>
#include <cstdint>

#include "bus/counters.hpp"
#include "bus/packets.hpp"

namespace polhode::bus {

// clang-format off
struct CounterRow {
  const char* name;
  std::uint32_t Counters::*counted;
  std::uint32_t HousekeepingPacket::*published;
};

inline constexpr std::array<CounterRow, 31> kCounters{{
    {"frames_in", &Counters::frames_in, &HousekeepingPacket::frames_in},
    {"frames_used", &Counters::frames_used, &HousekeepingPacket::frames_used},
    {"frames_unreadable", &Counters::frames_unreadable, &HousekeepingPacket::frames_unreadable},
    {"frames_dark", &Counters::frames_dark, &HousekeepingPacket::frames_dark},
    {"frames_wrong_size", &Counters::frames_wrong_size, &HousekeepingPacket::frames_wrong_size},
    {"frames_time_not_increasing", &Counters::frames_time_not_increasing, &HousekeepingPacket::frames_time_not_increasing},
    {"frames_held", &Counters::frames_held, &HousekeepingPacket::frames_held},
    {"frames_missing", &Counters::frames_missing, &HousekeepingPacket::frames_missing},
    {"frames_flat", &Counters::frames_flat, &HousekeepingPacket::frames_flat},
    {"frames_saturated", &Counters::frames_saturated, &HousekeepingPacket::frames_saturated},
    {"frames_frozen", &Counters::frames_frozen, &HousekeepingPacket::frames_frozen},
    {"frames_torn", &Counters::frames_torn, &HousekeepingPacket::frames_torn},
    {"frames_bit_errors", &Counters::frames_bit_errors, &HousekeepingPacket::frames_bit_errors},
    {"frames_blurred", &Counters::frames_blurred, &HousekeepingPacket::frames_blurred},
    {"frames_with_care", &Counters::frames_with_care, &HousekeepingPacket::frames_with_care},
    {"poses", &Counters::poses, &HousekeepingPacket::poses},
    {"lost", &Counters::lost, &HousekeepingPacket::lost},
    {"relocalised", &Counters::relocalised, &HousekeepingPacket::relocalised},
    {"restarts", &Counters::restarts, &HousekeepingPacket::restarts},
    {"start_contests", &Counters::start_contests, &HousekeepingPacket::start_contests},
    {"keyframes_inserted", &Counters::keyframes_inserted, &HousekeepingPacket::keyframes_inserted},
    {"keyframes_culled", &Counters::keyframes_culled, &HousekeepingPacket::keyframes_culled},
    {"landmarks_created", &Counters::landmarks_created, &HousekeepingPacket::landmarks_created},
    {"landmarks_culled", &Counters::landmarks_culled, &HousekeepingPacket::landmarks_culled},
    {"closures", &Counters::closures, &HousekeepingPacket::closures},
    {"shapes", &Counters::shapes, &HousekeepingPacket::shapes},
    {"jobs_issued", &Counters::jobs_issued, &HousekeepingPacket::jobs_issued},
    {"jobs_without_result", &Counters::jobs_without_result, &HousekeepingPacket::jobs_without_result},
    {"steps_short_of_memory", &Counters::steps_short_of_memory, &HousekeepingPacket::steps_short_of_memory},
    {"scale_contradictions", &Counters::scale_contradictions, &HousekeepingPacket::scale_contradictions},
    {"tables_full", &Counters::tables_full, &HousekeepingPacket::tables_full},
}};
// clang-format on

}  // namespace polhode::bus
