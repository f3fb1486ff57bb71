#include "app/servicer_attitude.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "errors.hpp"
#include "input_text.hpp"

namespace polhode::platform {
namespace {

constexpr double kNormError = 1e-2;

[[noreturn]] void refuse(const std::filesystem::path& file, int line, const char* what) {
  throw UnusableInput(fmt::format("{}:{}: {}", file.string(), line, what));
}

}  // namespace

ServicerAttitude ServicerAttitude::of_sequence(const std::filesystem::path& sequence) {
  const std::filesystem::path file = sequence / "servicer_attitude.csv";
  ServicerAttitude attitude;
  if (is_absent(file)) {
    return attitude;
  }
  const std::string table = read_text(file, kTableBytesMax);
  TextLines lines(table);
  for (std::string_view content; lines.next(&content);) {
    if (content.empty() || content.front() == '#') {
      continue;
    }
    const int line = lines.number();
    std::string text(content);
    std::replace(text.begin(), text.end(), ',', ' ');
    std::istringstream cells(text);
    Row row;
    Eigen::Quaterniond& q = row.q_IC;
    std::string rest;
    if (!(cells >> row.timestamp_ns >> q.w() >> q.x() >> q.y() >> q.z()) || cells >> rest) {
      refuse(file, line, "allowed is timestamp_ns,q_IC_w,q_IC_x,q_IC_y,q_IC_z");
    }
    if (!(std::abs(q.norm() - 1.0) < kNormError)) {
      refuse(file, line, "the quaternion's norm is not 1");
    }
    if (!attitude.rows_.empty() && row.timestamp_ns <= attitude.rows_.back().timestamp_ns) {
      refuse(file, line, "the time does not increase");
    }
    q.normalize();
    attitude.rows_.push_back(row);
  }
  if (attitude.rows_.empty()) {
    refuse(file, 1, "no rows");
  }
  return attitude;
}

Eigen::Quaterniond ServicerAttitude::q_IC(std::int64_t timestamp_ns) const {
  if (rows_.empty()) {
    return Eigen::Quaterniond::Identity();
  }
  const auto after = std::upper_bound(
      rows_.begin(), rows_.end(), timestamp_ns, [](std::int64_t time, const Row& row) {
        return time < row.timestamp_ns;
      });
  if (after == rows_.begin() || after == rows_.end()) {
    return after == rows_.begin() ? rows_.front().q_IC : rows_.back().q_IC;
  }
  const Row& before = *(after - 1);
  const double part = static_cast<double>(timestamp_ns - before.timestamp_ns) /
                      static_cast<double>(after->timestamp_ns - before.timestamp_ns);
  return before.q_IC.slerp(part, after->q_IC);
}

}  // namespace polhode::platform
