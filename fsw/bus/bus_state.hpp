// The state of the bus from step to step.
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

/// Landmarks in transmission, copied at the time of the request.
struct CloudRequest {
  FixedVector<std::array<float, 3>, limits::kLandmarks> points_T;  ///< in the unit given below
  std::size_t next = 0;                                            ///< first point not yet sent
  std::uint16_t number = 0;                                        ///< of the request, from 1
  std::int64_t timestamp_ns = 0;
  bool scale_known = false;
  double metres_per_mu = 1.0;
};

/// Points of one cloud packet: three coordinates each.
inline constexpr std::size_t kPointsPerChunk =
    std::tuple_size_v<decltype(bus::CloudPacket::p_T)> / 3;

/// Packets for this number of points.
constexpr std::size_t chunks_of(std::size_t points) {
  return (points + kPointsPerChunk - 1) / kPointsPerChunk;
}

/// The camera's attitude relative to inertial space, as last commanded.
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

/// Values at the end of the last step: events report their changes.
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
  std::uint32_t target_frame = 0;  ///< number of T at the last reported poses
};

/// Predictions in transmission, with the time, number and attitude of the frame that they start
/// from.
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
  ScaleNumber scale{};                                  ///< of the published lengths
  std::array<double, 4> q_CT_last{1.0, 0.0, 0.0, 0.0};  ///< published last, for a continuous sign
  std::uint32_t tables_damaged = 0;                     ///< found damaged in memory
};

}  // namespace polhode
