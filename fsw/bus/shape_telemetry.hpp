// Fills the shape packet.
#pragma once

#include "bus/packets.hpp"
#include "shape/shape.hpp"

namespace polhode::bus {

/// Scale of a run: metres per map unit, once it is known.
struct LengthUnit {
  bool known = false;
  double metres_per_mu = 1.0;
  double relative_sigma = 0.0;
  std::uint32_t number = 0;  ///< of the scale in force
};

/// All lengths in the unit. The caller sets time stamp and frame.
ShapePacket to_packet(const Shape& shape, const LengthUnit& unit);

/// Hamilton quaternion w, x, y, z of a rotation, w >= 0.
std::array<double, 4> quaternion_of(const Eigen::Matrix3d& R);

}  // namespace polhode::bus
