// A patterned arm at rest in the corner of the view, painted over a ball that turns.
#include "pipeline/own_structure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "bench.hpp"
#include "pipeline/checkpoint.hpp"

namespace polhode::own_structure_test {
namespace {

using namespace bench;

constexpr int kFrames = 14;  // an initialisation, and some frames behind it
constexpr int kArmWidth_px = 90;
constexpr int kArmTop_px = 150;

bool on_arm(int u, int v) { return u < kArmWidth_px && v >= kArmTop_px; }

OwnStructure drawing() {
  cv::Mat own = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      own.at<std::uint8_t>(v, u) = on_arm(u, v) ? 255 : 0;
    }
  }
  return own_structure(own);
}

/// The ball, with `cover` where the arm is.
Picture covered(int frame, const Picture& cover) {
  static const Ball ball(3);
  Picture picture = ball.seen_from(turning(frame));
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto at = static_cast<std::size_t>(v * kWidth + u);
      picture[at] = on_arm(u, v) ? cover[at] : picture[at];
    }
  }
  return picture;
}

struct Passage {
  std::vector<std::uint8_t> bytes;
  int poses = 0;
  std::size_t on_arm = 0;  ///< image points that lie on it
};

Passage run(const Picture& cover, const OwnStructure* own, bool restarted = false) {
  Bench b;
  set_own_structure(own, b.component);
  if (restarted) {
    std::vector<std::uint8_t> state(checkpoint_octets_max());
    const Bench other;
    state.resize(save_checkpoint(*other.component, state));
    EXPECT_TRUE(restore_checkpoint(state, b.component));
  }
  Passage passage;
  for (int frame = 0; frame < kFrames; ++frame) {
    const StepOutput& out = b.show(covered(frame, cover));
    passage.bytes.insert(passage.bytes.end(), out.packets.begin(), out.packets.end());
    passage.poses += out.motion.pose_valid ? 1 : 0;
    passage.on_arm += static_cast<std::size_t>(
        std::count_if(out.observations.begin(), out.observations.end(), [](const Observation& o) {
          return on_arm(static_cast<int>(o.u_px + 0.5F), static_cast<int>(o.v_px + 0.5F));
        }));
  }
  return passage;
}

// verifies: MSK-06
TEST(SetOwnStructure, WhatIsOnIt_ChangesNothing) {
  const OwnStructure own = drawing();
  const Passage patterned = run(clutter(1), &own);
  EXPECT_EQ(patterned.on_arm, 0U);
  EXPECT_GT(patterned.poses, 0);
  EXPECT_EQ(patterned.bytes, run(uniform(0), &own).bytes);
  EXPECT_EQ(patterned.bytes, run(uniform(255), &own).bytes);
}

TEST(SetOwnStructure, WithoutIt_TheArmIsTarget) {
  const Passage patterned = run(clutter(1), nullptr);
  EXPECT_GT(patterned.on_arm, 0U);
  EXPECT_NE(patterned.bytes, run(uniform(0), nullptr).bytes);
}

TEST(SetOwnStructure, StaysAcrossARestart) {
  const OwnStructure own = drawing();
  EXPECT_EQ(run(clutter(1), &own, true).bytes, run(uniform(0), &own, true).bytes);
}

}  // namespace
}  // namespace polhode::own_structure_test
