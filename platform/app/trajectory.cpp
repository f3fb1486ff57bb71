#include "app/trajectory.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "output_file.hpp"

namespace polhode::platform {

std::string tum_line(const MotionState& motion) {
  if (!is_measured(motion)) {
    return {};
  }
  const Eigen::Quaterniond q_CT(motion.q_CT[0], motion.q_CT[1], motion.q_CT[2], motion.q_CT[3]);
  const Eigen::Vector3d p_CT(motion.p_CT[0], motion.p_CT[1], motion.p_CT[2]);
  const Eigen::Quaterniond q_TC = q_CT.conjugate();
  const Eigen::Vector3d p_TC = -(q_TC * p_CT);
  // Whole and fractional seconds as integers: a double of today's time is only good to 0.2
  // microseconds.
  return fmt::format("{}.{:09d} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n",
                     motion.timestamp_ns / 1'000'000'000,
                     motion.timestamp_ns % 1'000'000'000,
                     p_TC.x(),
                     p_TC.y(),
                     p_TC.z(),
                     q_TC.x(),
                     q_TC.y(),
                     q_TC.z(),
                     q_TC.w());
}

void write_trajectory(const std::filesystem::path& file, std::span<const MotionState> motion) {
  OutputFile out(file);
  for (const MotionState& state : motion) {
    out.write(tum_line(state));
  }
  out.close();
}

void write_last_trajectory(const std::filesystem::path& file, std::span<const MotionState> motion) {
  OutputFile out(file);
  const auto last = std::find_if(motion.rbegin(), motion.rend(), is_measured);
  for (const MotionState& state : motion) {
    if (is_measured(state) && state.target_frame == last->target_frame &&
        state.scale_known == last->scale_known) {
      out.write(tum_line(state));
    }
  }
  out.close();
}

}  // namespace polhode::platform
