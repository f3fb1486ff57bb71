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
  /// Opens a device and lets go of it again, so that one that will never do is refused here; one
  /// that is away or busy is waited for later. A sequence gives `parameters` its own camera.
  /// @param machine must outlive the camera.
  /// @throws UnusableInput naming the file, the key and what is wrong.
  ChosenCamera(const std::filesystem::path& config,
               const MachineOptions& machine,
               Parameters* parameters);

  /// From now on frames come. Not before they can be taken: buffers would fill up with old ones,
  /// and a device that was unplugged meanwhile would not be missed.
  LiveCamera& start(const CameraParameters& parameters);

  /// That is played; nullptr for a device.
  [[nodiscard]] const Sequence* sequence() const { return sequence_ ? &*sequence_ : nullptr; }

 private:
  void refuse_unsuitable(const CameraParameters& parameters) const;
  void play();
  void open_device(const CameraParameters& parameters);

  std::filesystem::path config_;
  const DeviceOptions& device_;
  std::optional<Sequence> sequence_;
  std::unique_ptr<LiveCamera> camera_;
};

}  // namespace polhode::platform
