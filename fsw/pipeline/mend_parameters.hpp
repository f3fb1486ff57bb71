// Repairs parameters after bit flips, by three records: the active table, its copy from the step
// before, and the CRC.
#pragma once

#include "base/repair.hpp"

namespace polhode {

struct Configuration;

/// Two of the three that agree are right. Where no two do, both tables were hit:
/// 1. Values in which the tables differ are taken from the one or the other, so that the CRC is
/// right again. That restores all values, where none was hit in both.
/// 2. Else each such value is its default, and those of the camera are the camera model's. `reset`
/// is true: estimates made with the values before contradict the new ones.
/// Where the result is not a valid table, an assertion fails, so that the run restarts from its
/// configuration.
/// @return no entries, where nothing was hit.
Repair mend_parameters(Configuration* configuration);

}  // namespace polhode
