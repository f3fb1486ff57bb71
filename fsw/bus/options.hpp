#pragma once

namespace polhode {

struct BusOptions {
  int apid_motion = 0x1A0;  ///< application process id of the motion packet, 1 .. 2046
};

}  // namespace polhode
