// A request for the predicted position of a point of the body, and the answer.
#pragma once

#include <array>
#include <cstdint>

namespace polhode {

/// In the unit of published lengths: metres where the scale is known, else map units.
struct PointQuestion {
  std::int64_t timestamp_ns = 0;     ///< not before the last frame
  std::uint32_t target_frame = 0;    ///< number of the frame T that the point is in
  std::array<double, 3> p_T{};       ///< taken as exact
  std::array<double, 3> normal_T{};  ///< unit vector; zero: not requested
};

/// C has the orientation of the last frame. Values are valid only where their flag is up.
/// Covariances include the errors of motion, mass centre, map, scale and camera.
struct PointState {
  std::int64_t timestamp_ns = 0;       ///< of the request
  std::int64_t from_timestamp_ns = 0;  ///< of the last frame
  bool position_valid = false;  ///< 1-sigma under half of the distance, attitude's under 0.5 rad
  bool velocity_valid = false;  ///< with the position, by the dynamics alone
  bool normal_valid = false;    ///< requested, and its 1-sigma is under 0.5 rad
  bool scale_known = false;     ///< lengths are metres; else map units
  std::uint8_t dynamics = 0;    ///< basis, as in the packet: 1 the last poses, 2 and 3 the dynamics
  std::uint32_t scale_number = 0;  ///< as of MotionState
  std::array<double, 3> p_C{};
  std::array<double, 3> v_C{};  ///< relative to C's origin, per second
  std::array<double, 3> normal_C{};
  std::array<double, 6> cov_p{};  ///< of p_C: xx, xy, xz, yy, yz, zz
  std::array<double, 6> cov_v{};  ///< of v_C, likewise
  double sigma_normal_rad = 0.0;  ///< 1-sigma of its direction, worst axis
};

}  // namespace polhode
