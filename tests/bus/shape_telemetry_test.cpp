#include "bus/shape_telemetry.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>

#include "bus/packet_layout.hpp"
#include "bus/telemetry.hpp"

namespace polhode::bus::shape_telemetry_test {
namespace {

Shape boxed() {
  Shape shape;
  shape.frame.R_TB =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  shape.frame.source = FrameSource::kPlanes;
  shape.centroid_T = {0.1, 0.2, 0.3};
  shape.dimensions = {1.0, 2.0, 3.0};
  shape.sigma_dimensions = {0.01, 0.02, 0.03};
  shape.cloud_points = 70'000;  // more than its field holds
  Plane plane;
  plane.normal_T = {0.0, 1.0, 0.0};
  plane.offset = 0.5;
  plane.covariance.diagonal() = Eigen::Vector3d(1e-4, 4e-4, 9e-4);
  plane.inliers = 123;
  EXPECT_TRUE(shape.planes.push_back({}));
  EXPECT_TRUE(shape.planes.push_back(plane));
  return shape;
}

ShapePacket through_the_bus(ShapePacket packet) {
  std::array<std::uint8_t, shape_layout::kPacketOctets> octets{};
  EXPECT_EQ(encode(ShapePacket::layout(), &packet, {}, octets), octets.size());
  ShapePacket back;
  const Result<PacketHeader> header = decode(ShapePacket::layout(), octets, &back);
  EXPECT_TRUE(header.ok()) << (header ? "" : header.error().message);
  return back;
}

TEST(ShapePacketOf, HasLengthsInTheUnitGiven_AndAnglesUntouched) {
  const ShapePacket packet = through_the_bus(
      to_packet(boxed(), {.known = true, .metres_per_mu = 2.0, .relative_sigma = 0.01}));
  EXPECT_EQ(packet.dimensions, (std::array<double, 3>{2.0, 4.0, 6.0}));
  EXPECT_EQ(packet.centroid_T[2], 0.6);
  EXPECT_EQ(packet.plane_count, 2);
  EXPECT_EQ(packet.plane_offset[1], 1.0F);
  EXPECT_EQ(packet.plane_normal_T[4], 1.0F);
  EXPECT_NEAR(packet.plane_sigma[3], 0.01, 1e-7);
  EXPECT_NEAR(packet.plane_sigma[5], 0.06, 1e-7);
  EXPECT_EQ(packet.plane_inliers[1], 123);
  EXPECT_EQ(packet.cloud_points, 0xFFFF);
  EXPECT_EQ(packet.metres_per_mu, 2.0);
  EXPECT_EQ(packet.flags, shape_layout::kFlagShape | shape_layout::kFlagScaleKnown);
}

TEST(ShapePacketOf, HasItsFrameAsAUnitQuaternion) {
  const Shape shape = boxed();
  const ShapePacket packet = through_the_bus(to_packet(shape, {}));
  const Eigen::Quaterniond q(packet.q_TB[0], packet.q_TB[1], packet.q_TB[2], packet.q_TB[3]);
  EXPECT_NEAR(q.norm(), 1.0, 1e-12);
  EXPECT_LT((q.toRotationMatrix() - shape.frame.R_TB).norm(), 1e-12);
  EXPECT_EQ(packet.metres_per_mu, 0.0);  // unknown, and said so
}

TEST(ShapePacketOf, SaysNothingOfACylinderThatIsNotThere) {
  Shape shape = boxed();
  EXPECT_EQ(through_the_bus(to_packet(shape, {})).cylinder_radius, 0.0F);
  shape.cylinder = Cylinder{.radius = 0.75, .length = 2.0};
  const ShapePacket packet = through_the_bus(to_packet(shape, {}));
  EXPECT_EQ(packet.cylinder_radius, 0.75F);
  EXPECT_NE(packet.flags & shape_layout::kFlagCylinder, 0);
}

}  // namespace
}  // namespace polhode::bus::shape_telemetry_test
