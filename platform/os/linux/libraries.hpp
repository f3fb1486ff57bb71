// What third-party libraries would do to the machine on their own, switched off before anything
// else runs.
#pragma once

namespace polhode::platform {

/// One thread in the vision library, no graphics-card runtime.
void pin_libraries();

}  // namespace polhode::platform
