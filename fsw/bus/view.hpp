// The results of a step, as input of the bus.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "bus/counters.hpp"
#include "bus/length_unit.hpp"
#include "bus/options.hpp"
#include "image/frame_use.hpp"
#include "image/verdict.hpp"
#include "motion/motion_state.hpp"
#include "motion/stamp_doubt.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode {

struct BusState;
struct CameraModel;
struct MapDrift;
struct MotionEstimate;
struct MotionOptions;
struct Pose;
struct ScaleState;
struct ShapeState;

namespace bus {

/// The parameter table as housekeeping reports it.
struct TableStatus {
  std::uint32_t crc = 0;  ///< of the active table
  std::uint32_t loaded_crc = 0;
  std::uint32_t loaded_entries = 0;
  bool loaded = false;            ///< an inactive table is under way
  std::size_t memory_octets = 0;  ///< memory given to the component
};

/// The stated camera, and the result of its test.
struct CameraDoubt {
  const CameraModel* stated = nullptr;
  const CameraFinding* found = nullptr;
  CameraError error;
};

/// The results of a step, room by room. Pointers are never null.
struct View {
  FrameUse use = FrameUse::kUsed;
  FrameVerdict verdict;
  const MotionState* motion = nullptr;
  const Counters* counters = nullptr;
  const MotionEstimate* estimate = nullptr;
  const MapDrift* drift = nullptr;
  const Pose* pose = nullptr;  ///< of this frame; meaningful with motion->pose_valid
  StampDoubt stamps;           ///< of the last poses, where this frame has one
  const ShapeState* shape = nullptr;
  const ScaleState* scale = nullptr;
  CameraDoubt camera;
  LengthUnit unit;
  bool has_map = false;
  bool held = false;
  TableStatus table;
  const MotionOptions* motion_options = nullptr;
  const BusOptions* options = nullptr;
  std::string_view version;  ///< major.minor.patch
};

}  // namespace bus
}  // namespace polhode
