// Which build this program is.
#pragma once

#include <array>
#include <cstdint>

namespace polhode::platform {

using BuildId = std::array<std::uint8_t, 20>;

/// The linker's digest of the program (ELF note NT_GNU_BUILD_ID): another one for each other code,
/// compiler or option. Zeros where the program was linked without.
BuildId this_build();

}  // namespace polhode::platform
