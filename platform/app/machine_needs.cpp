#include "app/machine_needs.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "app/own_structure_file.hpp"
#include "camera/v4l2/formats.hpp"
#include "pipeline/checkpoint.hpp"
#include "recording/recorder.hpp"
#include "transport/address.hpp"

namespace polhode::platform {
namespace {

/// Of a pixel in a buffer of the device; where the device chooses, of the widest format that is
/// taken.
std::size_t buffer_bytes_per_pixel(std::string_view pixel_format) {
  constexpr std::size_t kCompressedMax = 2;
  const auto bytes = [](const PixelPacking& packing) {
    return packing.packing == Packing::kCompressed
               ? kCompressedMax
               : static_cast<std::size_t>(packing.bytes_per_pixel);
  };
  if (const PixelPacking* packing = find_packing(pixel_format)) {
    return bytes(*packing);
  }
  std::size_t most = 0;
  for (const PixelPacking& packing : pixel_packings()) {
    most = std::max(most, bytes(packing));
  }
  return most;
}

}  // namespace

MachineNeeds transport_needs(const TransportOptions& options, const CameraParameters& camera) {
  MachineNeeds needs{.rows = {},
                     .general_bytes = own_structure_bytes(options.own_structure_file, camera)};
  if (!options.transport.commands.key.empty()) {
    // OpenSSL's contexts of one MAC, given back after each; 3 kB with OpenSSL 3.0.
    constexpr std::size_t kMac_bytes = std::size_t{16} << 10U;
    needs.general_bytes += kMac_bytes;
  }
  for (const std::string& text : options.transport.send) {
    const AddressKind kind = parse_address(text).kind;
    if (kind == AddressKind::kUnix || kind == AddressKind::kUdp) {
      needs.general_bytes += DatagramSender::backlog_octets();
    } else if (kind == AddressKind::kShm) {
      needs.rows.push_back({"ring of packets in shared memory", RingWriter::octets()});
    }
  }
  return needs;
}

void add_sequence(const Sequence& sequence, MachineNeeds* needs) {
  // The libraries' own: tables and windows, and groups of rows before and after upsampling, under
  // 200 bytes a column for a JPEG (tests/platform/v4l2/jpeg_decoder_test.cpp), 32 for a PNG.
  constexpr std::size_t kTables = std::size_t{128} << 10U;
  constexpr std::size_t kPerColumn = 256;
  // In one piece: a block that the heap surely finds is up to a sixteenth smaller than the free
  // memory.
  const std::size_t whole = sequence.decoder_bytes + sequence.decoder_bytes / 16;
  needs->decoder_bytes =
      kTables + kPerColumn * static_cast<std::size_t>(sequence.camera.width_px) + whole;
  needs->rows.push_back({"the largest of the frames' files", sequence.file_bytes_max});
}

std::size_t recorded_frame_bytes(const CameraParameters& camera) {
  return 2 * static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px);
}

MachineNeeds live_needs(const MachineOptions& machine,
                        const TransportOptions& options,
                        const CameraParameters& camera) {
  MachineNeeds needs = transport_needs(options, camera);
  if (!machine.device.source.empty() && !std::filesystem::is_directory(machine.device.source)) {
    const std::size_t buffer_bytes = buffer_bytes_per_pixel(machine.device.pixel_format) *
                                     static_cast<std::size_t>(camera.width_px) *
                                     static_cast<std::size_t>(camera.height_px);
    needs.rows.push_back(
        {"buffers of the device", static_cast<std::size_t>(machine.device.buffers) * buffer_bytes});
  }
  if (!machine.run.checkpoint.empty()) {
    needs.rows.push_back({"checkpoint", checkpoint_octets_max()});
  }
  if (!machine.recording.folder.empty()) {
    needs.rows.push_back({"recording",
                          Recorder::bytes_needed(static_cast<std::size_t>(machine.recording.slots),
                                                 recorded_frame_bytes(camera))});
  }
  return needs;
}

}  // namespace polhode::platform
