// What the component remembers of the bus: packets, events, commands, the parameter table under
// way.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "base/time_doubt.hpp"
#include "bus/capacities.hpp"
#include "bus/events.hpp"
#include "bus/telemetry.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// A parameter table that is being loaded; the active one is State::parameters.
struct InactiveTable {
  bool begun = false;
  Parameters parameters;
  std::uint32_t crc = 0;  ///< CRC-32 over the octets of all entries loaded
  std::uint32_t entries = 0;
};

/// Landmarks on their way to the bus, as they were when they were asked for.
struct CloudRequest {
  FixedVector<std::array<float, 3>, limits::kLandmarks> points_T;  ///< in the unit said below
  std::size_t next = 0;                                            ///< first point not yet sent
  std::uint16_t number = 0;                                        ///< of the request, from 1
  std::int64_t timestamp_ns = 0;
  bool scale_known = false;
  double metres_per_mu = 1.0;
};

/// How the camera is turned relative to inertial space, as last told.
struct ServicerAttitude {
  bool known = false;
  std::int64_t timestamp_ns = 0;
  TimeDoubt doubt{};
  Eigen::Quaterniond q_IC = Eigen::Quaterniond::Identity();
  Eigen::Vector3d w_C_rad_s = Eigen::Vector3d::Zero();  ///< of C relative to I, in C
};

struct CommandCounts {
  std::uint32_t accepted = 0;
  std::uint32_t rejected = 0;
  std::uint8_t last_code = 0xFF;  ///< 0xFF: none yet
  bus::Rejection last_rejection = bus::Rejection::kNone;
};

/// What the last step ended with: events are told where this one differs.
struct ToldSoFar {
  bool started = false;
  Counters counters;
  Mode mode = Mode::kIdle;
  double metres_per_mu = 0.0;  ///< 0: lengths were in map units
  std::uint32_t frame_of_loss = 0;
  std::uint32_t target_frame = 0;  ///< that the last poses were told in
};

/// What goes on after a restart: counts without a gap, the commands' lasting effects.
struct BusRemembered {
  std::array<std::uint16_t, bus::kPacketKinds> sequence{};
  std::array<bus::EventCount, bus::kEventKinds> event_counts{};
  std::uint32_t event_window_begin = 0;
  std::uint32_t events_sent = 0;
  std::uint32_t events_suppressed = 0;
  std::uint32_t packets_not_sent = 0;
  CommandCounts commands;
  std::uint32_t table_crc = 0;
  std::uint16_t cloud_number = 0;
  bool held = false;
  ServicerAttitude servicer;
  ToldSoFar told;
};

struct BusState {
  bus::PacketStream stream;
  bus::EventLog events;
  CommandCounts commands;
  InactiveTable inactive;
  std::uint32_t table_crc = 0;  ///< of the active table
  bool held = false;
  bool background_planned = false;  ///< the libraries' memory was planned for a mask that tells a
                                    ///< background from the target
  CloudRequest cloud;
  ServicerAttitude servicer;
  ToldSoFar told;
  std::size_t memory_octets = 0;  ///< that the component was given
};

BusRemembered remember(const BusState& bus);
/// The component tells of its start again.
void recall(const BusRemembered& remembered, BusState* bus);

}  // namespace polhode
