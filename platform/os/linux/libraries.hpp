// Switches off what third-party libraries would choose by the machine, before anything else runs.
#pragma once

namespace polhode::platform {

/// One thread in the vision library, no graphics-card runtime; matrices are multiplied alike on all
/// machines.
void pin_libraries();

}  // namespace polhode::platform
