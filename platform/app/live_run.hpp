// The frame loop of a live run: camera, step, bus, until a request to stop.
#pragma once

#include <cstdint>

#include "app/live_counts.hpp"
#include "app/live_report.hpp"
#include "app/platform_telemetry.hpp"
#include "camera/live_camera.hpp"
#include "os/linux/service_manager.hpp"
#include "os/linux/worker.hpp"
#include "pipeline/component.hpp"
#include "recording/recorder.hpp"
#include "transport/file/packet_log.hpp"
#include "transport/transports.hpp"

namespace polhode::platform {

class CheckpointWriter;
class CrashWatch;
class ExposureControl;

enum class LiveEnd : std::uint8_t {
  kStopped,   ///< by a signal
  kPlayed,    ///< a played sequence is over
  kNoCamera,  ///< none within the time allowed at start
};

/// Parts that the loop uses. Those that may be absent are pointers.
struct LiveParts {
  Component& component;
  Worker& worker;
  LiveCamera& camera;
  ServiceManager& manager;
  LiveReport& report;
  LiveCounts& counts;
  Transports& transports;
  PlatformTelemetry& telemetry;
  PacketLog* packets = nullptr;
  Recorder* recorder = nullptr;
  CheckpointWriter* checkpoint = nullptr;
  CrashWatch* crash = nullptr;  ///< with the checkpoint
  ExposureControl& exposure;
};

struct LiveLimits {
  int checkpoint_frames = 50;
  int start_s_max = 10;
  int frames_max = 0;  ///< 0: as many as come
};

/// Takes no memory of its own.
LiveEnd run_live(LiveParts& parts, const LiveLimits& limits);

}  // namespace polhode::platform
