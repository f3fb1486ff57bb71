// A ball that turns before a rolling shutter: its observations, with the rows' times stated and
// not.
#include <gtest/gtest.h>

#include <algorithm>

#include "bench.hpp"
#include "geometry/so3.hpp"

namespace polhode::row_times_test {
namespace {

using namespace bench;

constexpr int kFrames = 16;
constexpr double kReadout = 0.8;  // of the second between frames: the ball turns by 3 deg meanwhile
constexpr double kLineTime_ns = kReadout * 1e9 / kHeight;

Pose tumbling(double frame) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.7, 0.5, 0.5).normalized();
  return {.R_CT = so3_exp(kTurn_rad * frame * axis), .p_CT = {0.05, -0.02, 8.0}};
}

/// Frames that a row is read after the middle one.
double delay_of(double v) { return kReadout * (v - 0.5 * (kHeight - 1)) / kHeight; }

/// @param direction  -1: the lowest row is read first.
Picture picture_of(int frame, double direction) {
  static const Ball ball(3);
  return ball.seen_by_rows([&](int v) { return tumbling(frame + direction * delay_of(v)); });
}

/// Where the point of the ball that is seen at (u, v) is at the frame's time, normalised.
Eigen::Vector2d at_frame(int frame, double direction, double u, double v) {
  const Pose seen = tumbling(frame + direction * delay_of(v));
  const Eigen::Vector3d ray((u - 160.0) / kFocal_px, (v - 120.0) / kFocal_px, 1.0);
  const Eigen::Vector3d unit = ray.normalized();
  const double along = unit.dot(seen.p_CT);
  const double root = std::sqrt(std::max(0.0, along * along - seen.p_CT.squaredNorm() + 1.0));
  const Eigen::Vector3d p_T = seen.R_CT.transpose() * ((along - root) * unit - seen.p_CT);
  return tumbling(frame).to_camera(p_T).hnormalized();
}

struct Errors {
  int observations = 0;
  double rms_px = 0.0;  ///< of inliers, against where they were at the frame's time
};

Errors errors_of(double stated_ns, double direction) {
  Parameters p = parameters();
  p.camera.line_time_ns = stated_ns;
  Bench b(p);
  Errors errors;
  double squares = 0.0;
  bool is_moving = false;  // the first pose has no motion before it to correct its rows by
  for (int i = 0; i < kFrames; ++i) {
    const StepOutput& out = b.show(picture_of(i, direction));
    const bool counts = is_moving;
    is_moving = is_moving || std::any_of(out.observations.begin(),
                                         out.observations.end(),
                                         [](const Observation& o) { return o.inlier; });
    for (const Observation& o : out.observations) {
      if (o.inlier && counts) {
        const Eigen::Vector2d given(o.normalised[0], o.normalised[1]);
        squares += (given - at_frame(i, direction, o.u_px, o.v_px)).squaredNorm();
        ++errors.observations;
      }
    }
  }
  errors.rms_px = kFocal_px * std::sqrt(squares / std::max(1, errors.observations));
  return errors;
}

// verifies: FEA-05
TEST(RowTimes, StatedAsTheyAreBringObservationsToTheFramesTime) {
  const Errors unstated = errors_of(0.0, 1.0);
  const Errors stated = errors_of(kLineTime_ns, 1.0);
  ASSERT_GT(stated.observations, 500);
  EXPECT_GT(unstated.rms_px, 0.25) << "a shear that matters: as much as a feature's sigma";
  EXPECT_LT(stated.rms_px, 0.1 * unstated.rms_px);
}

TEST(RowTimes, OfRowsReadUpwardsAreNegative) {
  EXPECT_LT(errors_of(-kLineTime_ns, -1.0).rms_px, 0.1 * errors_of(kLineTime_ns, -1.0).rms_px);
}

}  // namespace
}  // namespace polhode::row_times_test
