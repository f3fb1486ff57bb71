// The motion at one frame: the content of the motion packet and of a row of motion.csv.
#pragma once

#include <array>
#include <cstdint>

namespace polhode {

enum class Mode : std::uint8_t {
  kIdle = 0,
  kAcquiring = 1,
  kTracking = 2,
  kLost = 3,
  kCoasting = 4  ///< no usable image: the pose is the motion's prediction
};
inline constexpr Mode kLastMode = Mode::kCoasting;

/// Frames: C camera, T target, I inertial. Values are valid only where their flag is up.
struct MotionState {
  std::uint32_t frame = 0;  ///< index of the accepted frame
  std::int64_t timestamp_ns = 0;
  Mode mode = Mode::kIdle;
  bool pose_valid = false;
  bool rate_valid = false;
  bool velocity_valid = false;
  bool scale_known = false;  ///< lengths are metres; else map units
  std::uint32_t scale_number =
      0;  ///< of the scale in force: lengths of one number have one unit; in the packet modulo 16
  double metres_per_mu = 1.0;  ///< that scale; not in the packet
  std::uint32_t target_frame =
      0;  ///< number of the frame T that the pose is in; not in the packet (event target_frame_new)
  bool doubted = false;  ///< the pose is inconsistent with the motion, or repeats; the sigmas
                         ///< include the deviation; not in the packet
  std::array<double, 4> q_CT{1.0, 0.0, 0.0, 0.0};  ///< w, x, y, z; sign continuous in time
  std::array<double, 3> p_CT{};                    ///< T's origin in C
  std::array<double, 3> v_C{};        ///< its velocity relative to C's origin, in C, per second
  std::array<double, 3> w_T_rad_s{};  ///< target relative to inertial space, in T
  double sigma_att_rad = 0.0;         ///< 1-sigma, worst axis
  double sigma_pos = 0.0;             ///< 1-sigma, worst axis, unit of p_CT
  double sigma_vel = 0.0;             ///< 1-sigma, worst axis, unit of v_C
  double sigma_rate_rad_s = 0.0;      ///< 1-sigma, worst axis
  std::array<double, 21> cov_pose{};  ///< of (phi, dp) as in pose.hpp, upper triangle by rows
  std::array<double, 6> cov_v{};      ///< of v_C: xx, xy, xz, yy, yz, zz
  std::array<double, 6> cov_w{};      ///< of w_T, likewise
  std::uint16_t features = 0;         ///< detected or followed in this frame
  std::uint16_t matches = 0;          ///< associated with landmarks (or with tracks, before a map)
  std::uint16_t inliers = 0;          ///< that agree with the pose
  std::uint16_t landmarks = 0;        ///< in the map
  std::uint16_t keyframes = 0;        ///< in the map
};

/// A pose that the frame itself gave, not a predicted one.
inline bool is_measured(const MotionState& motion) {
  return motion.pose_valid && motion.mode != Mode::kCoasting;
}

}  // namespace polhode
