// SIGTERM and SIGINT request the run to stop; it does so between two frames.
#pragma once

namespace polhode::platform {

/// From now on the two signals only set a flag, and end a wait early. SIGPIPE is ignored: a reader
/// that goes away is an error of one call.
void listen_for_stop();

[[nodiscard]] bool stop_requested();

}  // namespace polhode::platform
