#include "app/motion_csv.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>

namespace polhode::platform {
namespace {

// Ten digits: below the noise of any camera by far, and short enough to read.
void cell(std::string& line, bool known, double value) {
  line += ',';
  if (known && std::isfinite(value)) {
    fmt::format_to(std::back_inserter(line), "{:.10g}", value);
  }
}

void cells(std::string& line, bool known, std::span<const double> values) {
  for (const double value : values) {
    cell(line, known, value);
  }
}

void count(std::string& line, bool known, unsigned value) {
  line += ',';
  if (known) {
    fmt::format_to(std::back_inserter(line), "{}", value);
  }
}

}  // namespace

const char* mode_name(Mode mode) {
  switch (mode) {
    case Mode::kIdle:
      return "IDLE";
    case Mode::kAcquiring:
      return "ACQUIRING";
    case Mode::kTracking:
      return "TRACKING";
    case Mode::kCoasting:
      return "COASTING";
    case Mode::kLost:
      return "LOST";
  }
  return "";
}

std::string motion_csv_header() {
  return "frame,timestamp_ns,mode,pose_valid,rate_valid,velocity_valid,scale_known,"
         "q_CT_w,q_CT_x,q_CT_y,q_CT_z,p_CT_x,p_CT_y,p_CT_z,v_C_x,v_C_y,v_C_z,w_T_x,w_T_y,w_T_z,"
         "sigma_att_rad,sigma_pos,sigma_vel,sigma_rate_rad_s,"
         "features,matches,inliers,landmarks,keyframes,step_us,target_frame,scale_number\n";
}

std::string motion_csv_row(const MotionRow& row, const MotionState& motion) {
  std::string line = fmt::format("{},{},{},{:d},{:d},{:d},{:d}",
                                 row.frame,
                                 row.timestamp_ns,
                                 mode_name(motion.mode),
                                 motion.pose_valid,
                                 motion.rate_valid,
                                 motion.velocity_valid,
                                 motion.scale_known);
  cells(line, motion.pose_valid, motion.q_CT);
  cells(line, motion.pose_valid, motion.p_CT);
  cells(line, motion.velocity_valid, motion.v_C);
  cells(line, motion.rate_valid, motion.w_T_rad_s);
  cell(line, motion.pose_valid, motion.sigma_att_rad);
  cell(line, motion.pose_valid, motion.sigma_pos);
  cell(line, motion.velocity_valid, motion.sigma_vel);
  cell(line, motion.rate_valid, motion.sigma_rate_rad_s);
  count(line, row.used, motion.features);
  count(line, row.used, motion.matches);
  count(line, row.used, motion.inliers);
  count(line, true, motion.landmarks);
  count(line, true, motion.keyframes);
  line += ',';
  if (row.step_us) {
    fmt::format_to(std::back_inserter(line), "{}", *row.step_us);
  }
  count(line, motion.pose_valid, motion.target_frame);
  count(line, motion.pose_valid, motion.scale_number);
  line += '\n';
  return line;
}

}  // namespace polhode::platform
