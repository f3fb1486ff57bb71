// What the component tells of the target beside its poses: shape, motion model, predictions.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>
#include <set>

#include "../bus/command_packets.hpp"
#include "bench.hpp"
#include "bus/packet_layout.hpp"
#include "geometry/so3.hpp"
#include "packets_of.hpp"
#include "pipeline/checkpoint.hpp"
#include "state_of.hpp"

namespace polhode::told_test {
namespace {

using namespace bench;
using bus::EventId;

constexpr int kFrames = 40;
constexpr std::uint32_t kEvery = 6;

/// A ball of radius 1 that turns by 3 deg a frame.
const std::vector<Picture>& pictures() {
  static const std::vector<Picture> rendered = [] {
    const Ball ball(61);
    std::vector<Picture> made;
    for (int i = 0; i < kFrames; ++i) {
      const Eigen::Matrix3d R_CT = so3_exp(Eigen::Vector3d(0.012, 0.052, 0.005) * i);
      made.push_back(ball.seen_from({.R_CT = R_CT, .p_CT = {0.0, 0.0, 6.0}}));
    }
    return made;
  }();
  return rendered;
}

Parameters redundant() {
  Parameters p = parameters();
  p.bus.shape_every_frames = static_cast<int>(kEvery);
  p.bus.model_every_frames = 2;
  return p;
}

/// All that one run has told.
struct Told {
  std::vector<bus::ShapePacket> shapes;
  std::vector<bus::ModelPacket> models;
  std::vector<bus::PredictionPacket> predictions;
  std::vector<MotionState> motion;
  int shapes_told_of = 0;
  std::size_t predictions_a_frame_max = 0;
  Counters counters;
  std::unique_ptr<Bench> bench;
};

Told run() {
  Told told;
  told.bench = std::make_unique<Bench>(redundant());
  for (const Picture& picture : pictures()) {
    const StepOutput& out = told.bench->show(picture);
    const auto append = [](const auto& from, auto* to) {
      to->insert(to->end(), from.begin(), from.end());
    };
    const auto predictions = packets_of<bus::PredictionPacket>(out);
    append(packets_of<bus::ShapePacket>(out), &told.shapes);
    append(packets_of<bus::ModelPacket>(out), &told.models);
    append(predictions, &told.predictions);
    told.predictions_a_frame_max = std::max(told.predictions_a_frame_max, predictions.size());
    told.motion.push_back(out.motion);
    for (const auto& event : packets_of<bus::EventPacket>(out)) {
      told.shapes_told_of += event.id == static_cast<std::uint16_t>(EventId::kShapeKnown) ? 1 : 0;
    }
  }
  told.counters = told.bench->component->counters();
  return told;
}

const Told& told() {
  static const Told one = run();
  return one;
}

TEST(ShapeTold, ComesWithTheFirstMap_AndAnewAsTheMapGrows) {
  const auto& shapes = told().shapes;
  ASSERT_GE(shapes.size(), 3U);
  std::set<std::uint32_t> estimates;
  for (const bus::ShapePacket& shape : shapes) {
    EXPECT_TRUE((shape.flags & bus::shape_layout::kFlagShape) != 0);
    EXPECT_LE(shape.frame_of_estimate, shape.frame);
    EXPECT_TRUE(shape.frame == shape.frame_of_estimate || shape.frame % kEvery == 0) << shape.frame;
    estimates.insert(shape.frame_of_estimate);
  }
  EXPECT_EQ(estimates.size(), told().counters.shapes);
  EXPECT_GE(told().shapes_told_of, 1);
  std::uint32_t last = 0;
  for (const std::uint32_t frame : estimates) {
    EXPECT_TRUE(last == 0 || frame - last >= kEvery) << frame;
    last = frame;
  }
}

TEST(ShapeTold, IsTheBodysOwn) {
  const bus::ShapePacket& last = told().shapes.back();
  EXPECT_GT(last.landmarks, 50);
  EXPECT_GT(last.cloud_points, 30);
  // T's origin and unit are those of the map: sizes can be told against the distance alone, and the
  // side that has been seen of a ball is up to its diameter wide.
  const MotionState& motion = told().motion.back();
  ASSERT_TRUE(motion.pose_valid);
  const double radius_mu = motion.p_CT[2] / 6.0;
  const double widest = *std::max_element(last.dimensions.begin(), last.dimensions.end());
  EXPECT_GT(widest, 1.0 * radius_mu);
  EXPECT_LT(widest, 2.4 * radius_mu);
}

TEST(ShapeTold, IsForgottenWithTheTarget) {
  Bench bench(redundant());
  for (int i = 0; i < 20; ++i) {
    (void)bench.show(pictures()[static_cast<std::size_t>(i)]);
  }
  ASSERT_TRUE(state_of(*bench.component).shape.shape.has_value());
  const auto reset = bus::command(bus::CommandCode::kResetMap);
  const std::vector<std::span<const std::uint8_t>> commands{reset};
  const Picture dark = uniform(0);
  const StepOutput& out = bench.component->step(
      {.frame = frame_of(++bench.time_s * Bench::kSecond_ns, dark), .commands = commands});
  EXPECT_TRUE(packets_of<bus::ShapePacket>(out).empty());
  EXPECT_FALSE(state_of(*bench.component).shape.shape.has_value());
}

TEST(ShapeTold, GoesOnAfterARestart) {
  const Component& before = *told().bench->component;
  std::vector<std::uint8_t> octets(checkpoint_octets_max());
  octets.resize(save_checkpoint(before, octets));
  Bench after(redundant());
  ASSERT_TRUE(restore_checkpoint(octets, after.component));
  const ShapeState& shape = state_of(*after.component).shape;
  ASSERT_TRUE(shape.shape.has_value());
  EXPECT_EQ(shape.shape->dimensions, state_of(before).shape.shape->dimensions);
  EXPECT_EQ(shape.frame_of_estimate, state_of(before).shape.frame_of_estimate);
}

TEST(ModelTold, IsTheDynamicsOnceTheyAreFitted_AndTheLocalRateBefore) {
  const auto& models = told().models;
  ASSERT_FALSE(models.empty());
  bool fitted = false;
  for (const bus::ModelPacket& model : models) {
    fitted = fitted || model.dynamics == 2;
    EXPECT_EQ(model.dynamics == 2, model.refusal == 0) << model.frame;
    if (model.dynamics == 2) {
      EXPECT_TRUE((model.flags & bus::model_layout::kFlagRate) != 0);
      // 3 deg a frame about one axis, which nothing but T's own choice of axes turns.
      const double rate =
          Eigen::Vector3d(model.w_T_rad_s[0], model.w_T_rad_s[1], model.w_T_rad_s[2]).norm();
      EXPECT_NEAR(rate, 0.0536, 0.01) << model.frame;
    }
  }
  EXPECT_TRUE(fitted);
}

TEST(PredictionsTold, AreOneAFrame_AndWhereTheBodyThenIs) {
  EXPECT_EQ(told().predictions_a_frame_max, 1U);
  int compared = 0;
  for (const bus::PredictionPacket& p : told().predictions) {
    const auto ahead = p.predicted_timestamp_ns - p.timestamp_ns;
    const auto then = static_cast<std::size_t>(p.predicted_timestamp_ns / Bench::kSecond_ns - 1);
    EXPECT_GE(ahead, 10 * Bench::kSecond_ns);
    if (then >= told().motion.size() || !told().motion[then].pose_valid ||
        (p.flags & bus::prediction_layout::kFlagAttitude) == 0) {
      continue;
    }
    const MotionState& m = told().motion[then];
    const Eigen::Quaterniond predicted(p.q_CT[0], p.q_CT[1], p.q_CT[2], p.q_CT[3]);
    const Eigen::Quaterniond found(m.q_CT[0], m.q_CT[1], m.q_CT[2], m.q_CT[3]);
    // Of the worst axis: the trace bounds it. Five sigma of both.
    const double sigma =
        std::sqrt(static_cast<double>(p.cov_pose[0] + p.cov_pose[6] + p.cov_pose[11]));
    EXPECT_LT(predicted.angularDistance(found), 5.0 * (sigma + m.sigma_att_rad)) << p.frame;
    ++compared;
  }
  EXPECT_GT(compared, 2);
}

}  // namespace
}  // namespace polhode::told_test
