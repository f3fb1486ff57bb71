#include "os/linux/standard_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <csignal>

namespace polhode::platform {

void prepare_standard_files() {
  // Output is opened for reading: writing to it fails, as it does to a closed one.
  constexpr int kModes[] = {O_RDONLY, O_RDONLY, O_WRONLY};
  for (int file = STDIN_FILENO; file <= STDERR_FILENO; ++file) {
    if (::fcntl(file, F_GETFD) < 0) {
      (void)::open("/dev/null", kModes[file]);  // the lowest number that is free is this one
    }
  }
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace polhode::platform
