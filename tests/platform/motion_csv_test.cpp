#include "app/motion_csv.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace polhode::platform::motion_csv_test {
namespace {

std::ptrdiff_t commas(const std::string& line) { return std::count(line.begin(), line.end(), ','); }

TEST(MotionCsv, UnknownValuesAreEmptyCells) {
  const MotionState unknown{.mode = Mode::kAcquiring, .features = 12};
  EXPECT_EQ(motion_csv_row({.frame = 3, .timestamp_ns = 50, .step_us = 9}, unknown),
            "3,50,ACQUIRING,0,0,0,0,,,,,,,,,,,,,,,,,,12,0,0,0,0,9,,\n");
  EXPECT_EQ(motion_csv_row({.frame = 3, .timestamp_ns = 50, .used = false}, unknown),
            "3,50,ACQUIRING,0,0,0,0,,,,,,,,,,,,,,,,,,,,,0,0,,,\n");
}

TEST(MotionCsv, KnownValuesFollowTheHeader) {
  const MotionState known{.mode = Mode::kTracking,
                          .pose_valid = true,
                          .rate_valid = true,
                          .velocity_valid = true,
                          .scale_known = true,
                          .scale_number = 17,
                          .target_frame = 2,
                          .q_CT = {0.5, -0.5, 0.5, -0.5},
                          .p_CT = {1, 2, 3},
                          .v_C = {4, 5, 6},
                          .w_T_rad_s = {7, 8, 9.25},
                          .sigma_att_rad = 0.1,
                          .sigma_pos = 0.2,
                          .sigma_vel = 0.3,
                          .sigma_rate_rad_s = 0.4,
                          .features = 1,
                          .matches = 2,
                          .inliers = 3,
                          .landmarks = 4,
                          .keyframes = 5};
  const std::string row = motion_csv_row({.frame = 0, .timestamp_ns = 1, .step_us = 6}, known);
  EXPECT_EQ(row,
            "0,1,TRACKING,1,1,1,1,0.5,-0.5,0.5,-0.5,1,2,3,4,5,6,7,8,9.25,0.1,0.2,0.3,0.4,1,2,3,4,5,"
            "6,2,17\n");
  EXPECT_EQ(commas(row), commas(motion_csv_header()));
}

TEST(MotionCsv, NotANumberIsAnEmptyCell) {
  MotionState state{.pose_valid = true};
  state.sigma_pos = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(motion_csv_row({}, state).find("nan"), std::string::npos);
}

}  // namespace
}  // namespace polhode::platform::motion_csv_test
