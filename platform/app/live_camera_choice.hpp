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
  /// Opens a device once, so that one that will never do is refused here; one that is away or busy
  /// is waited for later. A sequence gives `parameters` its own camera.
  /// @throws UnusableInput naming the file, the key and what is wrong.
  ChosenCamera(const std::filesystem::path& config,
               const MachineOptions& machine,
               Parameters* parameters);

  [[nodiscard]] LiveCamera& camera() { return *camera_; }

 private:
  void play(const DeviceOptions& device, Parameters* parameters);
  void open(const std::filesystem::path& config,
            const DeviceOptions& device,
            const Parameters& parameters);

  std::optional<Sequence> sequence_;
  std::unique_ptr<LiveCamera> camera_;
};

}  // namespace polhode::platform
