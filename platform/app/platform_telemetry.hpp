// Telemetry of the machine around the component: the packets of the field table that are in no
// replay, two once a second, and events. They go to the transports only, never into a run's
// bus.ccsds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "app/live_counts.hpp"
#include "bus/fields.hpp"
#include "bus/options.hpp"
#include "bus/packet_layout.hpp"
#include "camera/live_camera.hpp"
#include "transport/transports.hpp"

namespace polhode::platform {

/// Constants of the whole run.
struct PlatformFacts {
  bool watchdog = false;       ///< a service manager watches the run's progress
  bool locked_memory = false;  ///< no page leaves the memory
  bool real_time = false;      ///< the frames' thread has a real-time priority
  std::uint16_t restarts = 0;  ///< starts from a checkpoint since it was first made
};

class PlatformTelemetry {
 public:
  PlatformTelemetry(const BusOptions& options, const PlatformFacts& facts);
  ~PlatformTelemetry();
  PlatformTelemetry(const PlatformTelemetry&) = delete;
  PlatformTelemetry& operator=(const PlatformTelemetry&) = delete;

  /// Once a turn of the frame loop. Takes no memory.
  /// @param now_ns    monotonic
  /// @param frame_ns  time stamp of the last frame; 0 before the first
  void passed(const LiveCounts& counts,
              const LiveCamera& camera,
              Transports& transports,
              std::int64_t now_ns,
              std::int64_t frame_ns);

  /// At once. Takes no memory.
  void disk_refused(const WriteFailures& failures, Transports& transports, std::int64_t frame_ns);

 private:
  [[nodiscard]] std::uint64_t resident_octets() const;
  void send(const bus::Layout& layout,
            void* packet,
            std::uint16_t sequence,
            std::int64_t frame_ns,
            Transports& transports);

  BusOptions options_;
  PlatformFacts facts_;
  int statm_;  ///< held open: of the process, by the kernel
  std::int64_t begun_ns_ = 0;
  std::int64_t due_ns_ = 0;
  std::uint16_t sequence_ = 0;  ///< of both packets
  std::uint16_t events_ = 0;    ///< count of theirs
  std::array<std::uint8_t, bus::platform_event_layout::kPacketOctets> bytes_{};
};

}  // namespace polhode::platform
