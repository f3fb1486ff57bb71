#include "solve/bundle_part.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/rng.hpp"
#include "bundle_scene.hpp"
#include "geometry/so3.hpp"
#include "solve/bundle_adjustment.hpp"
#include "solve/settle_points.hpp"

namespace polhode::bundle_part_test {
namespace {

using testing::disturbed;
using testing::make_scene;
using Scene = testing::BundleScene;
using Chosen = std::vector<std::uint8_t>;

// The default of BundleOptions.
constexpr double kCauchySigma = 2.0;

std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

std::vector<std::size_t> of_each_point(const Scene& s) {
  std::vector<std::size_t> counts(s.points_T.size(), 0);
  for (const BundleObservation& o : s.observations) ++counts[index(o.point)];
  return counts;
}

/// Observations of each pose, of the chosen points.
std::vector<std::size_t> of_each_pose(const Scene& s, const Chosen& chosen) {
  std::vector<std::size_t> counts(s.poses.size(), 0);
  for (const BundleObservation& o : s.observations) counts[index(o.pose)] += chosen[index(o.point)];
  return counts;
}

/// Points of two to all poses: each has its own chance to be seen.
Scene uneven_scene(std::uint64_t seed) {
  Scene s = make_scene(12, 80, 0.0, seed);
  Rng rng(seed, 84);
  std::vector<double> chances(s.points_T.size());
  for (double& chance : chances) chance = rng.uniform();
  std::erase_if(s.observations, [&](const BundleObservation& o) {
    return o.pose > 1 && rng.uniform() > chances[index(o.point)];
  });
  return s;
}

/// 15 poses see 60 points, all of them; five new poses see 60 young points, each point by two.
Scene scene_with_new_poses() {
  Scene s = make_scene(20, 120, 0.0, 2);
  std::erase_if(s.observations, [](const BundleObservation& o) {
    const bool young = o.point >= 60;
    const int first = o.point % 5;
    const bool sees = o.pose - 15 == first || o.pose - 15 == (first + 1) % 5;
    return young ? !sees : o.pose >= 15;
  });
  return s;
}

Chosen all_of(const Scene& s) { return Chosen(s.points_T.size(), 1); }

TEST(ChoosePoints, TakesAll_WhereObservationsAndAThirdAsManyPointsFit) {
  Scene seen_often = make_scene(4, 10, 0.0, 1);  // 40 observations, for which ten points are few
  EXPECT_EQ(choose_points(seen_often.problem(), 40), all_of(seen_often));
  EXPECT_NE(choose_points(seen_often.problem(), 39), all_of(seen_often));
  Scene seen_twice = make_scene(2, 30, 0.0, 1);  // 60 observations: the points decide
  EXPECT_EQ(choose_points(seen_twice.problem(), 90), all_of(seen_twice));
  EXPECT_NE(choose_points(seen_twice.problem(), 89), all_of(seen_twice));
}

TEST(ChoosePoints, KeepsToItsLimits_AndFillsThem) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Scene s = uneven_scene(seed);
    const std::vector<std::size_t> views = of_each_point(s);
    for (std::size_t observations_max = 1; observations_max < s.observations.size();
         observations_max += 37) {
      const Chosen chosen = choose_points(s.problem(), observations_max);
      ASSERT_EQ(chosen.size(), s.points_T.size());
      std::size_t points = 0;
      std::size_t observations = 0;
      std::size_t fewest_left_out = s.observations.size();
      for (std::size_t i = 0; i < chosen.size(); ++i) {
        points += chosen[i];
        observations += chosen[i] * views[i];
        if (chosen[i] == 0) fewest_left_out = std::min(fewest_left_out, views[i]);
      }
      EXPECT_LE(observations, observations_max);
      EXPECT_LE(points, observations_max / 3);
      EXPECT_TRUE(points == observations_max / 3 ||
                  observations + fewest_left_out > observations_max)
          << points << " points, " << observations << " of " << observations_max;
    }
  }
}

TEST(ChoosePoints, FewPointsOfTwoObservationsFit) {
  Scene s = make_scene(2, 100, 0.0, 3);
  const Chosen chosen = choose_points(s.problem(), 120);
  // 60 points would have 120 observations.
  EXPECT_EQ(std::count(chosen.begin(), chosen.end(), 1), 40);
}

TEST(ChoosePoints, EveryPoseKeepsItsShare) {
  Scene s = scene_with_new_poses();
  const std::vector<std::size_t> all = of_each_pose(s, all_of(s));
  // Each a part of the scene's 1020 observations; the old points alone would fill up to 900.
  for (const std::size_t observations_max : {200U, 400U, 600U, 900U}) {
    const Chosen chosen = choose_points(s.problem(), observations_max);
    const std::vector<std::size_t> kept = of_each_pose(s, chosen);
    for (std::size_t k = 0; k < kept.size(); ++k) {
      EXPECT_GE(kept[k], std::min(all[k], observations_max / (2 * s.poses.size())))
          << "pose " << k << " of " << observations_max;
    }
  }
}

TEST(ChoosePoints, PrefersPointsOfMoreObservations_ThenThoseThatComeFirst) {
  Scene s = make_scene(6, 40, 0.0, 4);
  // Odd points are seen by every pose, even ones by half of them.
  std::erase_if(s.observations,
                [](const BundleObservation& o) { return o.point % 2 == 0 && o.pose % 2 == 0; });
  // All twenty odd points and four even ones; or the first ten odd ones.
  for (const auto& [odd, even] : {std::pair<int, int>(20, 4), std::pair<int, int>(10, 0)}) {
    Chosen expected(40, 0);
    for (int i = 0; i < odd; ++i) expected[index(2 * i + 1)] = 1;
    for (int i = 0; i < even; ++i) expected[index(2 * i)] = 1;
    const auto observations_max = static_cast<std::size_t>(6 * odd + 3 * even);
    EXPECT_EQ(choose_points(s.problem(), observations_max), expected) << odd;
    Scene reversed = s;
    std::reverse(reversed.observations.begin(), reversed.observations.end());
    EXPECT_EQ(choose_points(reversed.problem(), observations_max), expected) << odd;
  }
}

TEST(BundlePart, IsTheWhole_WhereItFits) {
  Scene s = disturbed(make_scene(4, 10, 0.0, 5), 5);
  const BundleProblem whole = s.problem();
  const BundlePart part(whole, 40);
  EXPECT_EQ(part.problem().points_T.data(), whole.points_T.data());
  EXPECT_EQ(part.problem().observations.data(), whole.observations.data());
  EXPECT_EQ(part.problem().points_T.size(), 10U);
  EXPECT_EQ(part.problem().observations.size(), 40U);
  const std::vector<Eigen::Vector3d> before = s.points_T;
  part.put_back(kCauchySigma);
  EXPECT_EQ(s.points_T, before) << "nothing was left out, nothing follows";
}

TEST(BundlePart, HoldsTheObservationsOfItsPoints_OnTheSamePoses) {
  Scene s = disturbed(uneven_scene(6), 6);
  for (std::size_t i = 0; i < s.point_fixed.size(); i += 3) s.point_fixed[i] = 1;
  std::vector<PosePrior> priors(3);
  BundleProblem whole = s.problem();
  whole.priors = priors;
  const std::size_t observations_max = s.observations.size() / 2;
  const Chosen chosen = choose_points(whole, observations_max);
  const BundlePart bundle(whole, observations_max);
  const BundleProblem& part = bundle.problem();
  EXPECT_EQ(part.poses.data(), whole.poses.data());
  EXPECT_EQ(part.poses.size(), whole.poses.size());
  EXPECT_EQ(part.pose_fixed.data(), whole.pose_fixed.data());
  EXPECT_EQ(part.priors.data(), priors.data());
  EXPECT_EQ(std::count(chosen.begin(), chosen.end(), 1), std::ssize(part.points_T));
  ASSERT_EQ(part.point_fixed.size(), part.points_T.size());
  std::size_t next = 0;
  for (const BundleObservation& o : whole.observations) {
    if (chosen[index(o.point)] == 0) continue;
    ASSERT_LT(next, part.observations.size());
    const BundleObservation& p = part.observations[next++];
    EXPECT_EQ(p.pose, o.pose);
    EXPECT_EQ(p.normalised, o.normalised);
    EXPECT_EQ(p.sigma_normalised, o.sigma_normalised);
    ASSERT_LT(index(p.point), part.points_T.size());
    EXPECT_EQ(part.points_T[index(p.point)], whole.points_T[index(o.point)]);
    EXPECT_EQ(part.point_fixed[index(p.point)], whole.point_fixed[index(o.point)]);
  }
  EXPECT_EQ(next, part.observations.size());
}

TEST(BundlePart, PutsItsPointsBack_AndTheOthersWhereTheirImagesWantThem) {
  const Scene truth = uneven_scene(7);
  // Two sigma of the images: poses that have moved a little.
  Scene s = disturbed(truth, 7, 0.3);
  for (std::size_t i = 0; i < s.point_fixed.size(); i += 7) s.point_fixed[i] = 1;
  const Scene before = s;
  const BundleProblem whole = s.problem();
  const std::size_t observations_max = s.observations.size() / 2;
  const Chosen chosen = choose_points(whole, observations_max);
  const BundlePart part(whole, observations_max);
  s.poses = truth.poses;  // in place: the problem's poses
  ASSERT_EQ(whole.poses.data(), s.poses.data());
  for (std::size_t i = 0; i < part.problem().points_T.size(); ++i) {
    part.problem().points_T[i] = {0.0, 0.0, static_cast<double>(i)};
  }
  EXPECT_EQ(s.points_T, before.points_T) << "until they are put back";
  part.put_back(kCauchySigma);
  std::size_t next = 0;
  int followed = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i] != 0) {
      EXPECT_EQ(s.points_T[i], Eigen::Vector3d(0.0, 0.0, static_cast<double>(next++))) << i;
    } else if (s.point_fixed[i] != 0) {
      EXPECT_EQ(s.points_T[i], before.points_T[i]) << i;
    } else {
      ++followed;
      // A thousandth of what it was off, which was two sigma of an image.
      EXPECT_LT((s.points_T[i] - truth.points_T[i]).norm(),
                1e-3 * (before.points_T[i] - truth.points_T[i]).norm())
          << i;
    }
  }
  EXPECT_GT(followed, 10);
  EXPECT_EQ(next, part.problem().points_T.size());
}

/// Square of the distance of two poses in sigma, as the images of the chosen points show them.
double distance2(const Scene& truth,
                 const Chosen& chosen,
                 std::size_t k,
                 const InverseDepthPose& a,
                 const InverseDepthPose& b) {
  Eigen::Matrix<double, 6, 1> off;
  off << so3_log(a.R_CT * b.R_CT.transpose()), a.uvs - b.uvs;
  double sum = 0.0;
  for (const BundleObservation& o : truth.observations) {
    LinearisedObservation l;
    if (index(o.pose) == k && chosen[index(o.point)] != 0) {
      EXPECT_TRUE(linearise(o, truth.poses[k], truth.points_T[index(o.point)], kCauchySigma, &l));
      sum += (l.by_pose * off).squaredNorm();
    }
  }
  return sum;
}

TEST(AdjustBundle, EndsNearTheWhole_WhereOnlyAPartIsAdjusted) {
  for (std::uint64_t seed = 60; seed < 65; ++seed) {
    Scene truth = make_scene(10, 100, 1.0, seed);
    truth.pose_fixed = {1, 0, 0, 0, 0, 0, 0, 0, 0, 1};  // far apart: they show the scale
    truth.point_fixed[2] = 1;                           // among those that are in,
    truth.point_fixed[97] = 1;                          // and those that are left out
    Scene whole = disturbed(truth, seed, 0.3);
    Scene part = whole;
    const Scene before = whole;
    const BundleOptions of_part{.iterations_max = 50, .observations_max = 500};
    const Chosen chosen = choose_points(part.problem(), of_part.observations_max);
    ASSERT_EQ(chosen[2] + 2 * chosen[97], 1);
    const BundleReport a = adjust_bundle(whole.problem(), {.iterations_max = 50});
    const BundleReport b = adjust_bundle(part.problem(), of_part);
    ASSERT_TRUE(a.usable && b.usable);
    EXPECT_LT(b.cost_before, 0.7 * a.cost_before) << "half of the observations";
    for (std::size_t k = 1; k + 1 < truth.poses.size(); ++k) {
      // Three sigma in each of six numbers.
      EXPECT_LT(distance2(truth, chosen, k, whole.poses[k], part.poses[k]), 9.0 * 6.0) << k;
    }
    // Eight poses that are off by a sigma in each number cost half of 48, and of the two halves of
    // the points only one was asked: a twentieth of the images' 1000 numbers; twice that.
    EXPECT_LT(bundle_cost(part.problem(), kCauchySigma), 1.1 * a.cost_after) << seed;
    for (const std::size_t i : {2U, 97U}) EXPECT_EQ(part.points_T[i], before.points_T[i]);
  }
}

}  // namespace
}  // namespace polhode::bundle_part_test
