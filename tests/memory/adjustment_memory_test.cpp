// What Ceres takes of a pool at the most, by which the jobs' pool is planned.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "os/linux/memory/region.hpp"
#include "solve/bundle_adjustment.hpp"
#include "solve/camera_adjustment.hpp"
#include "solve/free_body_adjustment.hpp"

namespace polhode::platform::adjustment_memory_test {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;
// Larger than any budget: what is measured is what was taken.
constexpr PoolBytes kPools{16 * kMiB, 8 * kMiB, 128 * kMiB, 8 * kMiB};
// Half a pixel of a lens of 1000 px.
constexpr double kSigma = 5e-4;

/// As many poses as the table holds about a ball; each point is seen by `views` poses in a row.
struct Scene {
  std::vector<InverseDepthPose> poses;
  std::vector<std::uint8_t> pose_fixed;
  std::vector<Eigen::Vector3d> points_T;
  std::vector<std::uint8_t> point_fixed;
  std::vector<BundleObservation> observations;
  std::vector<PoseTime> times;
  FreeBodyMotion motion;

  Scene(std::size_t views,
        std::size_t observations_count,
        std::size_t poses_count = BundleLimits::kPoses) {
    Rng rng(1, 70);
    const Eigen::Vector3d w_T(0.0, 0.05, 0.0);
    for (std::size_t k = 0; k < poses_count; ++k) {
      const auto time_s = static_cast<double>(k);
      poses.push_back(to_inverse_depth({.R_CT = so3_exp(time_s * w_T), .p_CT = {0.0, 0.0, 10.0}}));
      times.push_back({.time_s = time_s});
    }
    pose_fixed.assign(poses.size(), 0);
    const std::size_t points = std::min(observations_count / views, BundleLimits::kPoints);
    for (std::size_t i = 0; i < points; ++i) {
      points_T.push_back(Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized());
      for (std::size_t v = 0; v < views; ++v) {
        const std::size_t k = (i + v) % poses.size();
        Eigen::Vector2d x;
        EXPECT_TRUE(reproject(poses[k], points_T.back(), &x));
        observations.push_back(
            {.pose = static_cast<std::int32_t>(k),
             .point = static_cast<std::int32_t>(i),
             .normalised = x + kSigma * Eigen::Vector2d(rng.normal(), rng.normal()),
             .sigma_normalised = kSigma});
      }
    }
    point_fixed.assign(points_T.size(), 0);
    motion.reference.w_T_rad_s = w_T;
    motion.path.segment<3>(0) = Eigen::Vector3d(0.0, 0.0, 10.0);
  }

  [[nodiscard]] BundleProblem problem() {
    return {.poses = poses,
            .pose_fixed = pose_fixed,
            .points_T = points_T,
            .point_fixed = point_fixed,
            .observations = observations};
  }
};

/// @return bytes that the work takes of the jobs' pool at most.
template <typename Work>
std::size_t taken_by(const Work& work) {
  reset_pool_peaks();
  const std::size_t before = pool_use(Pool::kJobs).used_bytes;
  const PoolScope scope(Pool::kJobs);
  work();
  EXPECT_EQ(pool_use(Pool::kJobs).used_bytes, before) << "all of it is released";
  return pool_use(Pool::kJobs).peak_bytes - before;
}

class AdjustmentMemory : public ::testing::TestWithParam<std::size_t> {
 protected:
  static void SetUpTestSuite() {
    ASSERT_TRUE(memory_is_fixed()) << "this test must be linked with malloc_family.cpp";
    open_pools(kPools);
    // The first call opens files and keeps what it takes for good.
    Scene first(2, 1000);
    (void)adjust_bundle(first.problem(), {});
  }
};

TEST_P(AdjustmentMemory, IsWhatThePlanCountsWith) {
  for (const std::size_t observations : {std::size_t{2000}, std::size_t{10000}}) {
    Scene s(GetParam(), 3 * observations);
    const BundleOptions options{.iterations_max = 2, .observations_max = observations};
    bool usable = false;
    const std::size_t by_bundle =
        taken_by([&] { usable = adjust_bundle(s.problem(), options).usable; });
    EXPECT_TRUE(usable);
    const std::size_t by_free_body = taken_by([&] {
      usable =
          adjust_free_body({.bundle = s.problem(), .times = s.times, .motion = &s.motion}, options)
              .bundle.usable;
    });
    EXPECT_TRUE(usable);
    const std::size_t planned = adjustment_bytes_max(observations, s.poses.size());
    EXPECT_LE(by_bundle, planned);
    EXPECT_LE(by_free_body, planned);
    // A plan that counts with far more than is taken would be no measurement.
    EXPECT_GT(2 * std::max(by_bundle, by_free_body), planned);
  }
}

TEST_P(AdjustmentMemory, OfTheCameraIsWhatThePlanCountsWith) {
  constexpr std::size_t kObservations = 4200;
  constexpr std::size_t kPoses = 32;
  Scene s(GetParam(), kObservations, kPoses);
  const std::vector<PoseMotion> motions(kPoses);
  bool usable = false;
  const std::size_t taken = taken_by([&] {
    usable = adjust_camera({.bundle = s.problem(), .motions = motions},
                           {.iterations_max = 2, .observations_max = kObservations})
                 .usable;
  });
  EXPECT_TRUE(usable);
  EXPECT_LE(taken, adjustment_bytes_max(kObservations, kPoses));
  EXPECT_GT(2 * taken, adjustment_bytes_max(kObservations, kPoses));
}

INSTANTIATE_TEST_SUITE_P(Views, AdjustmentMemory, ::testing::Values(2, 6, 20));

}  // namespace
}  // namespace polhode::platform::adjustment_memory_test
