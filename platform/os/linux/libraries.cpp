#include "os/linux/libraries.hpp"

#include <stdlib.h>

#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core/utility.hpp>

namespace polhode::platform {

void pin_libraries() {
  // Eigen cuts the sums of large products into parts that fit the caches, so other caches would
  // give other bits. A present server's, as those that streams are recorded on.
  constexpr std::ptrdiff_t kLevel1_bytes = 48 * 1024;
  constexpr std::ptrdiff_t kLevel2_bytes = 1024 * 1024;
  constexpr std::ptrdiff_t kLevel3_bytes = 384 * 1024 * 1024;
  Eigen::setCpuCacheSizes(kLevel1_bytes, kLevel2_bytes, kLevel3_bytes);
  // With more threads the pool's own allocator maps memory for itself, and a step would no longer
  // be one thread.
  cv::setNumThreads(1);
  // Else the first call of the vision library loads a graphics-card runtime. An explicit choice
  // of the user stays.
  ::setenv("OPENCV_OPENCL_RUNTIME", "disabled", 0);
}

}  // namespace polhode::platform
