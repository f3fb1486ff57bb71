// Pages that must not leave the memory.
#pragma once

#include <string>

namespace polhode::platform {

/// Locks everything that is mapped now, with every page present.
/// @return why it could not be done; empty when it was.
std::string lock_memory();

}  // namespace polhode::platform
