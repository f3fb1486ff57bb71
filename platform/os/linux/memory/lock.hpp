// Pages that must not leave the memory.
#pragma once

#include <string>

namespace polhode::platform {

/// Locks everything that is mapped now: pages that have been used, as those of the pools and tables
/// have, and others from when they are. With every page of every library present it would be 46 MiB
/// more than the budgets have.
/// @return why it could not be done; empty when it was.
std::string lock_memory();

}  // namespace polhode::platform
