#include "app/machine_needs.hpp"

#include <filesystem>

#include "network/loaded_network.hpp"
#include "pipeline/checkpoint.hpp"
#include "recording/recorder.hpp"
#include "transport/address.hpp"

namespace polhode::platform {

MachineNeeds transport_needs(const TransportOptions& options) {
  MachineNeeds needs{.rows = {}, .general_octets = network_octets(options.network_file)};
  for (const std::string& text : options.transport.send) {
    const AddressKind kind = parse_address(text).kind;
    if (kind == AddressKind::kUnix || kind == AddressKind::kUdp) {
      needs.general_octets += DatagramSender::backlog_octets();
    } else if (kind == AddressKind::kShm) {
      needs.rows.push_back({"ring of packets in shared memory", RingWriter::octets()});
    }
  }
  return needs;
}

std::size_t recorded_frame_octets(const CameraParameters& camera) {
  return 2 * static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px);
}

MachineNeeds live_needs(const MachineOptions& machine,
                        const TransportOptions& options,
                        const CameraParameters& camera) {
  MachineNeeds needs = transport_needs(options);
  const std::size_t frame_octets = recorded_frame_octets(camera);
  if (!machine.device.source.empty() && !std::filesystem::is_directory(machine.device.source)) {
    needs.rows.push_back({"buffers of the device, two octets a pixel",
                          static_cast<std::size_t>(machine.device.buffers) * frame_octets});
  }
  if (!machine.run.checkpoint.empty()) {
    needs.rows.push_back({"checkpoint", checkpoint_octets_max()});
  }
  if (!machine.recording.folder.empty()) {
    needs.rows.push_back(
        {"recording",
         Recorder::octets_needed(static_cast<std::size_t>(machine.recording.slots), frame_octets)});
  }
  return needs;
}

}  // namespace polhode::platform
