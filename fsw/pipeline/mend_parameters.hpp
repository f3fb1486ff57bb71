// Parameters that bit flips have hit. Three things tell of them: the active table, its copy from
// the step before, and the CRC.
#pragma once

#include "base/repair.hpp"

namespace polhode {

struct Configuration;

/// Two of the three that agree are right. Where no two do, both tables were hit:
/// 1. Values in which the tables differ are taken from the one or the other, so that the CRC is
///    right again. That gives back what was, where no value was hit in both.
/// 2. Else each such value is its default, and those of the camera are what the camera model tells.
///    `reset` is true: what was estimated with the values before does not go with these.
/// Where that does not make a table that a component may start with, an assertion fails, so that
/// the run begins anew from its configuration.
/// @return none, where nothing was hit.
Repair mend_parameters(Configuration* configuration);

}  // namespace polhode
