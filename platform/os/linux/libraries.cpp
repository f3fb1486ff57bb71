#include "os/linux/libraries.hpp"

#include <stdlib.h>

#include <opencv2/core/utility.hpp>

namespace polhode::platform {

void pin_libraries() {
  // With more threads the pool's own allocator maps memory for itself, and a step would no longer
  // be one thread.
  cv::setNumThreads(1);
  // Else the first call of the vision library loads a graphics-card runtime. An explicit wish of
  // the user stays.
  ::setenv("OPENCV_OPENCL_RUNTIME", "disabled", 0);
}

}  // namespace polhode::platform
