#include "os/linux/stop_request.hpp"

#include <csignal>

namespace polhode::platform {
namespace {

volatile std::sig_atomic_t requested = 0;

extern "C" void request_stop(int /*signal*/) { requested = 1; }

}  // namespace

void listen_for_stop() {
  struct sigaction action {};
  action.sa_handler = request_stop;
  sigemptyset(&action.sa_mask);
  action.sa_flags = 0;  // no restart: poll and sleep return
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGINT, &action, nullptr);
  action.sa_handler = SIG_IGN;
  ::sigaction(SIGPIPE, &action, nullptr);
}

bool stop_requested() { return requested != 0; }

}  // namespace polhode::platform
