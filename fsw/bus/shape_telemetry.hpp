// Fills the shape packet.
#pragma once

#include "bus/length_unit.hpp"
#include "bus/packets.hpp"
#include "shape/shape.hpp"

namespace polhode::bus {

/// All lengths in the unit. The caller sets time stamp and frame.
ShapePacket to_packet(const Shape& shape, const LengthUnit& unit);

/// Hamilton quaternion w, x, y, z of a rotation, w >= 0.
std::array<double, 4> quaternion_of(const Eigen::Matrix3d& R);

}  // namespace polhode::bus
