// For tests: the frames of a run under the eyes of the kernel.
#pragma once

namespace polhode::platform {

/// Where wished, whoever asks the machine for memory or a thread from here on ends the program with
/// exit status 5. What follows the last frame may ask, and a filter of the kernel's stays for good:
/// the program ends there.
class FramesTrapped {
 public:
  /// @throws RunFailure when the kernel takes no filter.
  explicit FramesTrapped(bool requested);
  /// After the last frame: ends the process where it was wished, with status 0.
  void end() const;

 private:
  bool requested_;
};

}  // namespace polhode::platform
