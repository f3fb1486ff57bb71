// The EXIF orientation of a JPEG: how its pixels should be turned for display.
#pragma once

#include "camera/replay/decode.hpp"

namespace polhode::platform {

/// EXIF's orientation: 1 as stored, to 8. Also 1 where the file has none, or a damaged one.
int exif_orientation(Bytes jpeg);

}  // namespace polhode::platform
