// The servicer's own attitude over a sequence, from a file beside its images.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace polhode::platform {

/// q_IC over time; without rows the servicer keeps its attitude.
class ServicerAttitude {
 public:
  /// Reads `SEQ/servicer_attitude.csv` where there is one: a header line
  /// `#timestamp_ns,q_IC_w,q_IC_x,q_IC_y,q_IC_z`, times strictly increasing, unit quaternions.
  /// @throws UnusableInput naming file and line.
  static ServicerAttitude of_sequence(const std::filesystem::path& sequence);

  /// Interpolated on the sphere; held before the first row and after the last.
  [[nodiscard]] Eigen::Quaterniond q_IC(std::int64_t timestamp_ns) const;
  [[nodiscard]] Eigen::Matrix3d R_IC(std::int64_t timestamp_ns) const {
    return q_IC(timestamp_ns).toRotationMatrix();
  }
  /// For the step: w, x, y, z; nothing without rows.
  [[nodiscard]] std::optional<std::array<double, 4>> attitude_at(std::int64_t timestamp_ns) const {
    if (rows_.empty()) {
      return std::nullopt;
    }
    const Eigen::Quaterniond q = q_IC(timestamp_ns);
    return std::array<double, 4>{q.w(), q.x(), q.y(), q.z()};
  }

 private:
  struct Row {
    std::int64_t timestamp_ns = 0;
    Eigen::Quaterniond q_IC = Eigen::Quaterniond::Identity();
  };
  std::vector<Row> rows_;
};

}  // namespace polhode::platform
