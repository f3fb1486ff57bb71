// The camera that a configuration names: a device, or a sequence that is played.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "camera/live_camera.hpp"
#include "camera/replay/sequence.hpp"
#include "parameters/machine_options.hpp"
#include "pipeline/parameters.hpp"

namespace polhode::platform {

class ChosenCamera {
 public:
  /// Checks what can be known without opening anything. A sequence gives `parameters` its own camera.
  /// @param machine must outlive the camera.
  /// @throws UnusableInput naming the file, the key and what is wrong.
  ChosenCamera(const std::filesystem::path& config,
               const MachineOptions& machine,
               Parameters* parameters);

  /// Opens a device, so that one that will never do is refused here; one that is away or busy is waited
  /// for later. Not before frames can be taken: buffers would fill up with old ones, and a device that
  /// was unplugged meanwhile would not be missed.
  /// @throws UnusableInput, as above.
  LiveCamera& open(const Parameters& parameters);

 private:
  void play();
  void open_device(const CameraParameters& camera);

  std::filesystem::path config_;
  const DeviceOptions& device_;
  std::optional<Sequence> sequence_;
  std::unique_ptr<LiveCamera> camera_;
};

}  // namespace polhode::platform
