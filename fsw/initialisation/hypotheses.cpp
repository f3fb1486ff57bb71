#include "initialisation/hypotheses.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "base/median.hpp"
#include "geometry/so3.hpp"
#include "initialisation/extend.hpp"
#include "solve/affine_factorisation.hpp"
#include "solve/constant_rate_grid.hpp"
#include "solve/homography.hpp"
#include "solve/initial_adjustment.hpp"
#include "solve/relative_pose.hpp"

namespace polhode {
namespace {

// Weights of the assumption that the body is as deep as wide, in the upgrade from affine to metric.
// With much rotation the images give the depth; with little, noise would give it. Chosen: none,
// weak and strong.
constexpr std::array<double, 3> kIsotropies{0.0, 0.03, 0.3};
// Least points that a hypothesis from two views must place, and that two geometries must share.
// Chosen; with fewer a comparison by the median is a matter of chance.
constexpr std::size_t kHypothesisPointsMin = 8;
// Depths within a factor of two of their median: a body that is entirely in view reaches no
// farther.
constexpr double kDepthFactorMax = 2.0;
// Two rotations are compared relative to the larger, and at least to this: ratios of smaller ones
// are noise.
constexpr double kRotationMin_rad = 0.02;

/// The core's images, frame by frame, rotated so that the mean of the tracks lies on the optical
/// axis. Weak perspective is best there.
struct CoreImages {
  std::array<std::array<Eigen::Vector2d, kCoreTracks>, kCoreFrames> x;
  std::array<Eigen::Matrix3d, kCoreFrames> R_SC;  ///< rotated from camera
  ImageMatrix turned;
  double sigma_normalised = 0.0;  ///< mean
};

std::size_t track_of(const InitialCore& core, std::size_t column) {
  return static_cast<std::size_t>(core.tracks[column]);
}

CoreImages collect(const SeedProblem& problem) {
  const InitialCore& core = *problem.core;
  CoreImages images;
  double sigma = 0.0;
  int count = 0;
  for (const TrackObservation& s : problem.observations) {
    const auto* const frame = std::find(core.frames.begin(), core.frames.end(), s.frame);
    const auto* const track = std::find(core.tracks.begin(), core.tracks.end(), s.track);
    if (frame != core.frames.end() && track != core.tracks.end()) {
      images.x[static_cast<std::size_t>(frame - core.frames.begin())]
              [static_cast<std::size_t>(track - core.tracks.begin())] = s.normalised;
      sigma += s.sigma_normalised;
      ++count;
    }
  }
  POLHODE_ASSERT(count == static_cast<int>(core.tracks.size() * core.frames.size()), count);
  images.sigma_normalised = sigma / count;
  const auto F = static_cast<Eigen::Index>(core.frames.size());
  const auto N = static_cast<Eigen::Index>(core.tracks.size());
  images.turned.resize(2 * F, N);
  for (Eigen::Index f = 0; f < F; ++f) {
    const auto& row = images.x[static_cast<std::size_t>(f)];
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < core.tracks.size(); ++i) {
      mean += row[i].homogeneous().normalized();
    }
    const Eigen::Matrix3d R =
        Eigen::Quaterniond::FromTwoVectors(mean, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    images.R_SC[static_cast<std::size_t>(f)] = R;
    for (Eigen::Index i = 0; i < N; ++i) {
      const Eigen::Vector2d x = (R * row[static_cast<std::size_t>(i)].homogeneous()).hnormalized();
      images.turned(f, i) = x.x();
      images.turned(F + f, i) = x.y();
    }
  }
  return images;
}

InitialHypothesis empty_hypothesis(const SeedProblem& problem, HypothesisKind kind) {
  InitialHypothesis h;
  h.kind = kind;
  h.frames = problem.times_s.size();
  h.tracks = problem.selection_tracks;
  return h;
}

/// Seeds by weak perspective, which leaves depth and its sign undetermined. Inverse depth is the
/// image scale per extent.
/// @param h  an empty hypothesis. @return false where the motion gives none.
bool pose_by_weak_perspective(const SeedProblem& problem,
                              const CoreImages& images,
                              std::span<const std::uint8_t> inlier,
                              const WeakPerspectiveMotion& motion,
                              InitialHypothesis* h) {
  const InitialCore& core = *problem.core;
  const Eigen::Matrix3Xd points = weak_perspective_points(images.turned, inlier, motion);
  double extent2 = 0.0;
  double count = 0.0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (inlier[static_cast<std::size_t>(i)] != 0) {
      extent2 += points.col(i).squaredNorm();
      count += 1.0;
    }
  }
  const double extent = std::sqrt(extent2 / std::max(1.0, count));
  if (!(extent > 0.0) || !std::isfinite(extent)) {
    return false;
  }
  const Eigen::VectorXd means = images.turned.col(0) - centred(images.turned, inlier).col(0);
  const auto F = static_cast<Eigen::Index>(core.frames.size());
  for (Eigen::Index f = 0; f < F; ++f) {
    const auto k = static_cast<std::size_t>(f);
    const auto frame = static_cast<std::size_t>(core.frames[k]);
    const double depth = 1.0 / (motion.scale[k] * extent);
    const Eigen::Vector3d p_S(means(f) * depth, means(F + f) * depth, depth);
    const Pose pose{.R_CT = images.R_SC[k].transpose() * motion.R_CT[k],
                    .p_CT = images.R_SC[k].transpose() * p_S};
    if (!is_before_camera(pose)) {
      return false;
    }
    h->poses[frame] = to_inverse_depth(pose);
    h->posed[frame] = 1;
  }
  for (std::size_t i = 0; i < core.tracks.size(); ++i) {
    h->points_T[track_of(core, i)] = points.col(static_cast<Eigen::Index>(i)) / extent;
    h->known[track_of(core, i)] = 1;
  }
  return true;
}

void seed_weak_perspective(const SeedProblem& problem,
                           const CoreImages& images,
                           InitialHypotheses* seeds) {
  const InitialCore& core = *problem.core;
  const AffineSubspace subspace =
      find_affine_subspace(images.turned, images.sigma_normalised, problem.seed);
  if (!subspace.valid) {
    return;
  }
  if ((problem.kinds & kind_bit(HypothesisKind::kFactorisation)) != 0) {
    for (const double isotropy : kIsotropies) {
      WeakPerspectiveMotion motion;
      InitialHypothesis h = empty_hypothesis(problem, HypothesisKind::kFactorisation);
      if (upgrade_to_metric(subspace, isotropy, &motion) &&
          pose_by_weak_perspective(problem, images, subspace.inlier.view(), motion, &h)) {
        (void)seeds->push_back(h);
      }
    }
  }
  if ((problem.kinds & kind_bit(HypothesisKind::kConstantRate)) != 0) {
    FixedVector<double, kCoreFrames> times;
    for (const int f : core.frames) {
      (void)times.push_back(problem.times_s[static_cast<std::size_t>(f)]);
    }
    ImageMatrix chosen(images.turned.rows(), subspace.inliers);
    const ImageMatrix relative = centred(images.turned, subspace.inlier.view());
    for (Eigen::Index i = 0, n = 0; i < relative.cols(); ++i) {
      if (subspace.inlier[static_cast<std::size_t>(i)] != 0) {
        chosen.col(n++) = relative.col(i);
      }
    }
    for (const ConstantRateMotion& rate : search_constant_rate(chosen, times.view())) {
      InitialHypothesis h = empty_hypothesis(problem, HypothesisKind::kConstantRate);
      const WeakPerspectiveMotion motion = to_motion(rate, times.view());
      if (pose_by_weak_perspective(problem, images, subspace.inlier.view(), motion, &h)) {
        (void)seeds->push_back(h);
      }
    }
  }
}

struct TwoViews {
  std::array<std::size_t, 2> pair;  ///< of the core's frames: a, b
  RelativePose motion;
  std::array<double, kCoreTracks> depth_a;  ///< of each core track in a; not positive: unknown
};

/// Seeds from two views, with T's origin in the middle of the points. The core's other frames
/// follow by resection.
/// @param h  an empty hypothesis. @return false where the views give none.
bool pose_by_two_views(const SeedProblem& problem,
                       const CoreImages& images,
                       const TwoViews& views,
                       InitialHypothesis* h) {
  const InitialCore& core = *problem.core;
  const auto& [pair, motion, depth_a] = views;
  FixedVector<double, kCoreTracks> positive;
  for (std::size_t i = 0; i < core.tracks.size(); ++i) {
    if (depth_a[i] > 0.0 && std::isfinite(depth_a[i])) {
      (void)positive.push_back(depth_a[i]);
    }
  }
  if (positive.size() < kHypothesisPointsMin || 2 * positive.size() < core.tracks.size()) {
    return false;
  }
  const double middle = median(positive.view());
  const Eigen::Vector3d origin = middle * images.R_SC[pair[0]].transpose().col(2);
  const Pose pose_a{.p_CT = origin};
  const Pose pose_b{.R_CT = motion.R_ba, .p_CT = motion.R_ba * origin + motion.p_ba};
  if (!is_before_camera(pose_a) || !is_before_camera(pose_b)) {
    return false;
  }
  h->poses[static_cast<std::size_t>(core.frames[pair[0]])] = to_inverse_depth(pose_a);
  h->poses[static_cast<std::size_t>(core.frames[pair[1]])] = to_inverse_depth(pose_b);
  h->posed[static_cast<std::size_t>(core.frames[pair[0]])] = 1;
  h->posed[static_cast<std::size_t>(core.frames[pair[1]])] = 1;
  for (std::size_t i = 0; i < core.tracks.size(); ++i) {
    if (depth_a[i] > middle / kDepthFactorMax && depth_a[i] < kDepthFactorMax * middle) {
      h->points_T[track_of(core, i)] = depth_a[i] * images.x[pair[0]][i].homogeneous() - origin;
      h->known[track_of(core, i)] = 1;
    }
  }
  if (!normalise_gauge(h->view())) {
    return false;
  }
  for (std::size_t k = 0; k < core.frames.size(); ++k) {
    if (k != pair[0] && k != pair[1] &&
        !pose_frame(problem.observations, problem.times_s, core.frames[k], h)) {
      return false;
    }
  }
  return true;
}

void seed_two_view(const SeedProblem& problem,
                   const CoreImages& images,
                   std::array<std::size_t, 2> pair,
                   InitialHypotheses* seeds) {
  const InitialCore& core = *problem.core;
  const std::span x_a = std::span(images.x[pair[0]]).first(core.tracks.size());
  const std::span x_b = std::span(images.x[pair[1]]).first(core.tracks.size());
  const TwoViewOptions options{.sigma_normalised = images.sigma_normalised,
                               .seed = problem.seed + pair[1]};
  if ((problem.kinds & kind_bit(HypothesisKind::kFivePoint)) != 0) {
    for (const RelativePoseCandidate& candidate : find_relative_poses(x_a, x_b, options)) {
      TwoViews views{.pair = pair, .motion = candidate.motion, .depth_a = {}};
      for (std::size_t i = 0; i < core.tracks.size(); ++i) {
        views.depth_a[i] = depth_in_a(candidate.motion, x_a[i], x_b[i]);
      }
      InitialHypothesis h = empty_hypothesis(problem, HypothesisKind::kFivePoint);
      if (pose_by_two_views(problem, images, views, &h)) {
        (void)seeds->push_back(h);
      }
    }
  }
  if ((problem.kinds & kind_bit(HypothesisKind::kHomography)) != 0) {
    for (const PanelMotion& panel : find_homography(x_a, x_b, options).motions) {
      TwoViews views{.pair = pair, .motion = panel.motion, .depth_a = {}};
      for (std::size_t i = 0; i < core.tracks.size(); ++i) {
        views.depth_a[i] = 1.0 / panel.normal_a.dot(x_a[i].homogeneous());
      }
      InitialHypothesis h = empty_hypothesis(problem, HypothesisKind::kHomography);
      if (pose_by_two_views(problem, images, views, &h)) {
        (void)seeds->push_back(h);
      }
    }
  }
}

}  // namespace

void seed_hypotheses(const SeedProblem& problem, InitialHypotheses* seeds) {
  POLHODE_ASSERT(problem.core->frames.size() >= 3, problem.core->frames.size());
  seeds->clear();
  const CoreImages images = collect(problem);
  seed_weak_perspective(problem, images, seeds);
  const std::size_t last = problem.core->frames.size() - 1;
  // The widest pair has the most parallax. A pair of half its width may decide where the widest
  // leaves the pose ambiguous.
  seed_two_view(problem, images, {0, last}, seeds);
  seed_two_view(problem, images, {0, (last + 1) / 2}, seeds);
}

bool same_geometry(const InitialHypothesis& a, const InitialHypothesis& b, double tolerance) {
  FixedVector<double, limits::kSelectionTracks> apart;
  for (std::size_t i = 0; i < a.tracks; ++i) {
    if (a.known[i] != 0 && b.known[i] != 0) {
      (void)apart.push_back((a.points_T[i] - b.points_T[i]).norm());
    }
  }
  // Hypotheses of different cores may share no points.
  if (apart.size() < kHypothesisPointsMin) {
    return false;
  }
  // The median: the point of a wrong track may lie anywhere (decision 0029).
  if (median(apart.view()) > tolerance) {
    return false;
  }
  double largest = 0.0;
  double difference = 0.0;
  std::size_t first = a.frames;
  for (std::size_t f = 0; f < a.frames; ++f) {
    if (a.posed[f] == 0 || b.posed[f] == 0) {
      continue;
    }
    first = std::min(first, f);
    const Eigen::Matrix3d turn_a = a.poses[f].R_CT * a.poses[first].R_CT.transpose();
    const Eigen::Matrix3d turn_b = b.poses[f].R_CT * b.poses[first].R_CT.transpose();
    difference = std::max(difference, rotation_angle_rad(turn_a, turn_b));
    largest = std::max(largest, so3_log(turn_a).norm());
  }
  return difference <= tolerance * std::max(largest, kRotationMin_rad);
}

}  // namespace polhode
