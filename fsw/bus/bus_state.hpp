// Everything that this room remembers from step to step.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "base/earlier_times.hpp"
#include "base/fixed_vector.hpp"
#include "bus/capacities.hpp"
#include "bus/commands.hpp"
#include "bus/counters.hpp"
#include "bus/events.hpp"
#include "bus/repeated_commands.hpp"
#include "bus/telemetry.hpp"
#include "motion/look_ahead.hpp"
#include "motion/motion_state.hpp"
#include "shape/scale_number.hpp"
#include "solve/camera_adjustment.hpp"

namespace polhode {

/// Landmarks on their way to the bus, as they were when they were asked for.
struct CloudRequest {
  FixedVector<std::array<float, 3>, limits::kLandmarks> points_T;  ///< in the unit said below
  std::size_t next = 0;                                            ///< first point not yet sent
  std::uint16_t number = 0;                                        ///< of the request, from 1
  std::int64_t timestamp_ns = 0;
  bool scale_known = false;
  double metres_per_mu = 1.0;
};

/// Points of one cloud packet: three coordinates each.
inline constexpr std::size_t kPointsPerChunk =
    std::tuple_size_v<decltype(bus::CloudPacket::p_T)> / 3;

/// Packets that so many points take.
constexpr std::size_t chunks_of(std::size_t points) {
  return (points + kPointsPerChunk - 1) / kPointsPerChunk;
}

/// How the camera is turned relative to inertial space, as last commanded.
struct ServicerAttitude {
  bool known = false;
  std::int64_t timestamp_ns = 0;
  EarlierTimes doubt{};
  Eigen::Quaterniond q_IC = Eigen::Quaterniond::Identity();
  Eigen::Vector3d w_C_rad_s = Eigen::Vector3d::Zero();  ///< of C relative to I, in C
};

struct CommandCounts {
  std::uint32_t accepted = 0;
  std::uint32_t rejected = 0;
  std::uint8_t last_code = 0xFF;  ///< 0xFF: none yet
  bus::Rejection last_rejection = bus::Rejection::kNone;
};

/// What the last step ended with: events report where this one differs.
struct Reported {
  bool started = false;
  Counters counters;
  Mode mode = Mode::kIdle;
  bool stamps_doubted = false;
  bool rate_implausible = false;
  std::array<std::uint8_t, kDeviations> contradicted{};  ///< of the stated camera
  std::uint8_t dynamics = 0;                             ///< a value of the model packet's field
  ScaleNumber scale{};
  std::uint32_t scale_not_improved = 0;
  std::uint32_t frame_of_loss = 0;
  std::uint32_t target_frame = 0;  ///< that the last poses were reported in
};

/// Predictions on their way to the bus, and what the frame that they start from had.
struct PredictionsUnderWay {
  LookAhead walk;
  std::int64_t timestamp_ns = 0;
  std::uint32_t frame = 0;
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();
};

/// The state of this room.
struct BusState {
  bus::PacketStream stream;
  bus::EventLog events;
  CommandCounts commands;
  bus::CommandsDone commands_done;
  CloudRequest cloud;
  ServicerAttitude servicer;
  PredictionsUnderWay predictions;
  Reported reported;
  ScaleNumber scale{};                                  ///< that lengths are published under
  std::array<double, 4> q_CT_last{1.0, 0.0, 0.0, 0.0};  ///< published last: signs go on from it
  std::uint32_t tables_damaged = 0;                     ///< found so in memory
};

}  // namespace polhode
