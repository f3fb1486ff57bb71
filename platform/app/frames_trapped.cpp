#include "app/frames_trapped.hpp"

#include <unistd.h>

#include <cstdio>

#include "errors.hpp"
#include "os/linux/memory/trap.hpp"

namespace polhode::platform {

FramesTrapped::FramesTrapped(bool requested) : requested_(requested) {
  // Frames, recordings and checkpoints are files.
  constexpr bool kFiles = false;
  if (requested_ && !set_memory_trap(kFiles)) {
    throw RunFailure("the kernel takes no filter: nothing would be watched");
  }
}

void FramesTrapped::end() const {
  if (requested_) {
    std::fputs("nothing was asked of the machine\n", stderr);
    ::_exit(0);
  }
}

}  // namespace polhode::platform
