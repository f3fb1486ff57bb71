// What one run has learnt of its target is given to another one: in other light, at another range,
// with another camera.
#include "pipeline/target_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/rng.hpp"
#include "bench.hpp"
#include "bus/event_table.hpp"
#include "packets_of.hpp"
#include "pipeline/state.hpp"

namespace polhode::target_model_test {
namespace {

using namespace bench;

constexpr int kFrames = 40;
using Octets = std::vector<std::uint8_t>;

Octets model_of(const Component& component) {
  Octets octets(target_model_octets_max());
  octets.resize(save_target_model(component, octets));
  return octets;
}

/// A ball that turns by 4 deg a frame, and what was learnt of it.
const Octets& model() {
  static const Octets octets = [] {
    Bench first;
    show_first(images_of_turning(kFrames), kFrames, &first);
    return model_of(*first.component);
  }();
  return octets;
}

/// Half as bright, with less contrast where it is dark.
Picture in_other_light(Picture picture) {
  for (std::uint8_t& pixel : picture) {
    pixel = static_cast<std::uint8_t>(std::lround(0.5 * std::pow(pixel / 255.0, 1.5) * 255.0));
  }
  return picture;
}

/// Another pass: as it was at one of the first pass's frames, rolled in the image and farther away.
Pose of_second_pass(int i) {
  const Pose before = turning(12 + 0.5 * i);
  const Eigen::AngleAxisd roll(0.7, Eigen::Vector3d::UnitZ());
  return {.R_CT = roll * before.R_CT, .p_CT = {-0.1, 0.08, 10.0}};
}

Parameters with_another_camera() {
  Parameters p = parameters();
  p.camera.width_px = 400;  // the same pictures with a margin, told as what they are
  p.camera.height_px = 300;
  p.camera.cu_px += 40.0;
  p.camera.cv_px += 30.0;
  return p;
}

Picture with_margin(const Picture& picture) {
  Picture wide(400 * 300, 0);
  for (int v = 0; v < kHeight; ++v) {
    std::copy_n(picture.begin() + v * kWidth, kWidth, wide.begin() + (v + 30) * 400 + 40);
  }
  return wide;
}

struct SecondPass {
  std::vector<MotionState> motion;
  std::vector<bus::EventPacket> events;
};

SecondPass second_pass(std::uint64_t ball, const Octets& learnt) {
  Bench b(with_another_camera());
  EXPECT_TRUE(load_target_model(learnt, b.component).ok());
  const Ball body(ball);
  SecondPass pass;
  for (int i = 0; i < 14; ++i) {
    const Picture picture = with_margin(in_other_light(body.seen_from(of_second_pass(i))));
    const StepOutput& out =
        b.component->step({.frame = frame_of(++b.time_s * Bench::kSecond_ns, picture, 400, 300)});
    pass.motion.push_back(out.motion);
    for (const bus::EventPacket& event : packets_of<bus::EventPacket>(out))
      pass.events.push_back(event);
  }
  return pass;
}

/// T is the first pass's: axes of its first frame, up to its own error. @return deg.
double axes_error_deg(const Octets& learnt, const MotionState& m, const Pose& truth) {
  Bench first;
  EXPECT_TRUE(load_target_model(learnt, first.component).ok());
  const Component::State& s = *ComponentAccess::state(*first.component);
  // The keyframe that the first pass took of frame 0 tells what T is.
  const Keyframe& oldest = s.mapping.map.keyframes[0];
  const Eigen::Matrix3d R_TT = turning(0).R_CT.transpose() * oldest.pose.R_CT;
  return rotation_angle_rad(rotation_of(m), truth.R_CT * R_TT) * 57.3;
}

// verifies: MAP-12
TEST(TargetModel, IsRecognisedInOtherLight_AtAnotherRange_ByAnotherCamera_InTheSameT) {
  const SecondPass pass = second_pass(3, model());
  const auto first = std::find_if(
      pass.motion.begin(), pass.motion.end(), [](const MotionState& m) { return m.pose_valid; });
  ASSERT_LT(first - pass.motion.begin(), 10);
  for (auto m = first; m != pass.motion.end(); ++m) {
    ASSERT_TRUE(m->pose_valid);
    EXPECT_EQ(m->target_frame, 1U);
    const double error_deg =
        axes_error_deg(model(), *m, of_second_pass(static_cast<int>(m - pass.motion.begin())));
    EXPECT_LT(error_deg, 3.4 * 57.3 * m->sigma_att_rad + 0.5);  // 99 % of three numbers
    EXPECT_LT(error_deg, 4.0);
  }
  EXPECT_EQ(std::count_if(pass.events.begin(),
                          pass.events.end(),
                          [](const bus::EventPacket& e) {
                            return e.id ==
                                   static_cast<std::uint16_t>(bus::EventId::kTargetFoundAgain);
                          }),
            1);
}

// verifies: MAP-12
TEST(TargetModel, OfAnotherBodyIsNotTaken) {
  for (const std::uint64_t ball : {4U, 5U, 6U}) {
    for (const MotionState& m : second_pass(ball, model()).motion) {
      EXPECT_FALSE(m.pose_valid && m.target_frame == 1) << ball << ", frame " << m.frame;
    }
  }
}

TEST(TargetModel, SavedAgainIsTheSame) {
  Bench b;
  const Result<TargetModelFacts> facts = load_target_model(model(), b.component);
  ASSERT_TRUE(facts.ok());
  EXPECT_GT(facts.value().landmarks, 100U);
  EXPECT_GT(facts.value().keyframes, 10U);
  EXPECT_GT(facts.value().radius_mu, 0.5);
  const Octets again = model_of(*b.component);
  ASSERT_EQ(again.size(), model().size());
  // Blobs' sizes and sigmas went through pixels and back, in single precision; after that nothing
  // changes any more.
  Bench c;
  ASSERT_TRUE(load_target_model(again, c.component).ok());
  EXPECT_EQ(model_of(*c.component), again);
}

TEST(TargetModel, WithoutAMapThereIsNone) {
  const Bench b;
  EXPECT_EQ(model_of(*b.component).size(), 0U);
}

// verifies: MAP-12
TEST(TargetModel, CutOffOrOfAnotherVersionChangesNothing) {
  Bench b;
  Octets other = model();
  other[0] ^= 0xFFU;
  EXPECT_FALSE(load_target_model(other, b.component).ok());
  Octets longer = model();
  longer.push_back(0);
  EXPECT_FALSE(load_target_model(longer, b.component).ok());
  for (std::size_t octets = 0; octets < model().size(); octets += 1 + model().size() / 40) {
    EXPECT_FALSE(load_target_model(std::span(model()).first(octets), b.component).ok()) << octets;
  }
  Bench untouched;
  const Picture picture = Ball(3).seen_from(turning(0));
  const StepOutput& a = b.show(picture);
  const StepOutput& u = untouched.show(picture);
  EXPECT_TRUE(std::equal(a.packets.begin(), a.packets.end(), u.packets.begin(), u.packets.end()));
}

// verifies: MAP-12
TEST(TargetModel, WithFlippedBitsIsRefusedOrTheStepsGoOn) {
  Rng rng(7, 1);
  const Ball body(3);
  for (int trial = 0; trial < 30; ++trial) {
    Octets flipped = model();
    for (int k = 0; k < 4; ++k) {
      flipped[rng.below(static_cast<std::uint32_t>(trial < 15 ? 600 : flipped.size()))] ^=
          static_cast<std::uint8_t>(1U << rng.below(8));
    }
    Bench b;
    if (load_target_model(flipped, b.component).ok()) {
      for (int i = 0; i < 3; ++i) {
        (void)b.show(body.seen_from(of_second_pass(i)));
      }
    }
  }
}

}  // namespace
}  // namespace polhode::target_model_test
