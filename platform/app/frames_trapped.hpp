// For tests: the frames of a run under the eyes of the kernel.
#pragma once

namespace polhode::platform {

/// On request, any call for memory or a thread from here on ends the program with exit status 5.
/// Work after the last frame may call, but a filter of the kernel stays for good: so the program
/// ends at the last frame.
class FramesTrapped {
 public:
  /// @throws RunFailure when the kernel takes no filter.
  explicit FramesTrapped(bool requested);
  /// After the last frame: ends the process where it was requested, with status 0.
  void end() const;

 private:
  bool requested_;
};

}  // namespace polhode::platform
