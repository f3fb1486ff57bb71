#include "os/linux/libraries.hpp"

#include <glog/logging.h>
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
  // The solver logs by glog, which would open files in the folder for temporary files. What a solve
  // came to is in its report; only what ends the program is left to say.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;
}

}  // namespace polhode::platform
