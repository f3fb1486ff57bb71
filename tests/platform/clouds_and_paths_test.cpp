#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "app/ply.hpp"
#include "app/trajectory.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::clouds_and_paths_test {
namespace {

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// verifies: PRG-07
TEST(Trajectory, IsTheCameraSeenFromTheTarget) {
  // The target turned by 90 deg about z and 5 ahead of the camera: p_TC = -R_CT^T (1, 0, 5) = (0,
  // 1, -5).
  MotionState state{.timestamp_ns = 1700000000000000123, .pose_valid = true};
  state.q_CT = {0.5, 0.0, 0.0, 0.5};
  state.q_CT[0] = state.q_CT[3] = 0.70710678118654757;
  state.p_CT = {1.0, 0.0, 5.0};
  std::istringstream line(tum_line(state));
  std::string stamp;
  double v[7] = {};
  line >> stamp;
  for (double& value : v) line >> value;
  EXPECT_EQ(stamp, "1700000000.000000123");
  const double expected[7] = {0.0, 1.0, -5.0, 0.0, 0.0, -0.707106781, 0.707106781};
  for (int i = 0; i < 7; ++i) {
    EXPECT_NEAR(v[i], expected[i], 1e-9) << i;  // nine digits are written
  }
}

TEST(Trajectory, LeavesOutFramesWithoutAPose) {
  const TemporaryFolder folder;
  MotionState states[3];
  states[1].pose_valid = true;
  write_trajectory(folder.path() / "t.tum", states);
  const std::string text = content(folder.path() / "t.tum");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
}

TEST(Trajectory, OfTheLastFrameTAndUnitAlone) {
  const TemporaryFolder folder;
  MotionState states[6];
  for (std::int64_t i = 0; i < 6; ++i) {
    states[i].timestamp_ns = i;
    states[i].pose_valid = i != 3 && i != 5;
    states[i].target_frame = i < 1 ? 1 : 2;
    states[i].scale_known = i >= 2;
  }
  write_last_trajectory(folder.path() / "t.tum", states);
  const std::string text = content(folder.path() / "t.tum");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'),
            2);  // 0: another T; 1: map units; 3 and 5: no pose
  EXPECT_EQ(text.find("0.000000002 "), 0U);
  EXPECT_NE(text.find("\n0.000000004 "), std::string::npos);
  write_last_trajectory(folder.path() / "none.tum", std::span(states).subspan(3, 1));
  EXPECT_EQ(content(folder.path() / "none.tum"), "");
}

TEST(Ply, HoldsWhatItsHeaderSays) {
  const TemporaryFolder folder;
  const Eigen::Vector3d points[] = {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
  const Eigen::Vector3d normals[] = {{0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}};
  const std::array<std::uint8_t, 3> rgb[] = {{1, 2, 3}, {4, 5, 6}};
  write_ply(folder.path() / "c.ply",
            {.points = points, .normals = normals, .rgb = rgb, .comment = "frame T"});
  const std::string text = content(folder.path() / "c.ply");
  const std::size_t data = text.find("end_header\n") + 11;
  EXPECT_NE(text.find("element vertex 2\n"), std::string::npos);
  ASSERT_EQ(text.size() - data, 2U * (6 * 4 + 3));
  float x = 0.0F;
  std::memcpy(
      &x, text.data() + data + 27, sizeof x);  // on the little-endian machines that tests run on
  EXPECT_EQ(x, 4.0F);
}

TEST(Ply, MarksAddedPointsAndHoldsFaces) {
  const TemporaryFolder folder;
  const Eigen::Vector3d points[] = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  const std::uint8_t added[] = {0, 0, 1};
  const std::array<std::uint32_t, 3> faces[] = {{0, 1, 2}};
  write_ply(folder.path() / "c.ply",
            {.points = points,
             .normals = {},
             .rgb = {},
             .added = added,
             .faces = faces,
             .comment = "frame T"});
  const std::string text = content(folder.path() / "c.ply");
  EXPECT_NE(text.find("property uchar added\nelement face 1\nproperty list uchar int "
                      "vertex_indices\nend_header\n"),
            std::string::npos);
  const std::size_t data = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size() - data, 3U * 13U + 1U + 3U * 4U);
  EXPECT_EQ(text[data + 12], 0);
  EXPECT_EQ(text[data + 38], 1);
  EXPECT_EQ(text[data + 39], 3);
  EXPECT_EQ(text[data + 48], 2);
}

TEST(Ply, HoldsSigmaAndViewsAfterTheMark) {
  const TemporaryFolder folder;
  const Eigen::Vector3d points[] = {{1.0, 2.0, 3.0}};
  const std::uint8_t added[] = {0};
  const float sigma[] = {0.25F};
  const std::int32_t views[] = {7};
  write_ply(folder.path() / "c.ply",
            {.points = points,
             .normals = {},
             .rgb = {},
             .added = added,
             .sigma = sigma,
             .views = views,
             .comment = "frame T"});
  const std::string text = content(folder.path() / "c.ply");
  const std::size_t data = text.find("end_header\n") + 11;
  EXPECT_NE(
      text.find("property uchar added\nproperty float sigma\nproperty int views\nend_header\n"),
      std::string::npos);
  ASSERT_EQ(text.size() - data, 3U * 4U + 1U + 4U + 4U);
  float read_sigma = 0.0F;
  std::int32_t read_views = 0;
  std::memcpy(&read_sigma, text.data() + data + 13, sizeof read_sigma);
  std::memcpy(&read_views, text.data() + data + 17, sizeof read_views);
  EXPECT_EQ(read_sigma, 0.25F);
  EXPECT_EQ(read_views, 7);
}

TEST(Ply, MayBeEmpty) {
  const TemporaryFolder folder;
  write_ply(folder.path() / "c.ply",
            {.points = {}, .normals = {}, .rgb = {}, .comment = "frame T"});
  EXPECT_NE(content(folder.path() / "c.ply").find("element vertex 0\n"), std::string::npos);
}

}  // namespace
}  // namespace polhode::platform::clouds_and_paths_test
