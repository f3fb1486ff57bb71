#include "initialisation/extend.hpp"

#include <algorithm>
#include <cmath>

#include "base/median.hpp"
#include "geometry/so3.hpp"
#include "solve/initial_adjustment.hpp"
#include "solve/triangulate.hpp"

namespace polhode {
namespace {

using FrameObservations = FixedVector<TrackObservation, limits::kSelectionTracks>;

// Twice the three points that a pose needs without noise.
constexpr int kSeenPointsMin = 6;
// Widths of the Cauchy loss. An initial pose may be off by a frame's rotation, tens of pixels; the
// second pass rejects outliers at the noise.
constexpr double kWideSigma = 30.0;
constexpr double kNarrowSigma = 3.0;
// Damped steps of each pass. Chosen: enough for a good initial pose, and a bound for a bad one.
constexpr int kPoseIterations = 10;
// Longest continuation of the depth, in steps of the last interval. Chosen: a ratio of noisy depths
// grows as a power.
constexpr double kDepthStepsMax = 2.0;
// In RMS extents: a point farther away is not of the body. Chosen; wider than the cue's
// kHullReachMax, as the adjustment may still move it back.
constexpr double kReachMax = 5.0;

/// (u, v) for a given attitude and inverse depth: the median over the points.
void place(const FrameObservations& seen, const InitialHypothesis& h, InverseDepthPose* pose) {
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    FixedVector<double, limits::kSelectionTracks> values;
    for (const TrackObservation& s : seen) {
      const Eigen::Vector3d q = pose->R_CT * h.points_T[static_cast<std::size_t>(s.track)];
      (void)values.push_back(s.normalised(axis) * (1.0 + pose->uvs.z() * q.z()) -
                             pose->uvs.z() * q(axis));
    }
    pose->uvs(axis) = median(values.view());
  }
}

/// The two nearest posed frames, on either side or both on one; -1 where there is none.
std::array<int, 2> neighbours(const InitialHypothesis& h, int frame) {
  FixedVector<int, limits::kInitialFrames> posed;
  for (int f = 0; f < static_cast<int>(h.frames); ++f) {
    if (h.posed[static_cast<std::size_t>(f)] != 0) {
      (void)posed.push_back(f);
    }
  }
  std::sort(posed.begin(), posed.end(), [frame](int a, int b) {
    const int da = std::abs(a - frame);
    const int db = std::abs(b - frame);
    return da != db ? da < db : a < b;
  });
  return {posed.empty() ? -1 : posed[0], posed.size() < 2 ? -1 : posed[1]};
}

InverseDepthPose continued(const InverseDepthPose& near,
                           const InverseDepthPose& far,
                           double fraction) {
  InverseDepthPose pose = near;
  pose.R_CT = so3_exp(fraction * so3_log(near.R_CT * far.R_CT.transpose())) * near.R_CT;
  pose.uvs.z() = near.uvs.z() * std::pow(near.uvs.z() / far.uvs.z(),
                                         std::clamp(fraction, -kDepthStepsMax, kDepthStepsMax));
  return pose;
}

double refine(const FrameObservations& seen, InitialHypothesis* h, InverseDepthPose* pose) {
  InitialAdjustmentOptions options{
      .iterations_max = kPoseIterations, .loss = InitialLoss::kCauchy, .width_sigma = kWideSigma};
  if (adjust_single_pose(seen.view(), h->view(), options, pose) < 0.0) {
    return -1.0;
  }
  options.width_sigma = kNarrowSigma;
  return adjust_single_pose(seen.view(), h->view(), options, pose);
}

}  // namespace

bool pose_frame(std::span<const TrackObservation> observations,
                std::span<const double> times_s,
                int frame,
                InitialHypothesis* hypothesis) {
  InitialHypothesis& h = *hypothesis;
  FrameObservations seen;
  for (const TrackObservation& s : observations) {
    if (s.frame == frame && h.known[static_cast<std::size_t>(s.track)] != 0) {
      (void)seen.push_back(s);
    }
  }
  const auto [near, far] = neighbours(h, frame);
  if (seen.size() < static_cast<std::size_t>(kSeenPointsMin) || near < 0) {
    return false;
  }
  const InverseDepthPose& near_pose = h.poses[static_cast<std::size_t>(near)];
  FixedVector<InverseDepthPose, 2> starts;
  (void)starts.push_back(near_pose);
  if (far >= 0) {
    const auto time = [&](int f) { return times_s[static_cast<std::size_t>(f)]; };
    const double fraction = (time(frame) - time(near)) / (time(near) - time(far));
    (void)starts.push_back(continued(near_pose, h.poses[static_cast<std::size_t>(far)], fraction));
  }
  constexpr double kNoCost = 1e300;  // above every cost
  double best = kNoCost;
  InverseDepthPose best_pose;
  for (InverseDepthPose& start : starts) {
    place(seen, h, &start);
    const double cost = refine(seen, &h, &start);
    if (cost >= 0.0 && cost < best) {
      best = cost;
      best_pose = start;
    }
  }
  if (best == kNoCost) {
    return false;
  }
  h.poses[static_cast<std::size_t>(frame)] = best_pose;
  h.posed[static_cast<std::size_t>(frame)] = 1;
  return true;
}

void add_points(std::span<const TrackObservation> observations, InitialHypothesis* hypothesis) {
  InitialHypothesis& h = *hypothesis;
  for (std::size_t begin = 0; begin < observations.size();) {
    const auto track = static_cast<std::size_t>(observations[begin].track);
    std::size_t end = begin;
    FixedVector<RayObservation, limits::kInitialFrames> seen;
    for (; end < observations.size() && observations[end].track == observations[begin].track;
         ++end) {
      const auto frame = static_cast<std::size_t>(observations[end].frame);
      if (h.posed[frame] != 0 && h.known[track] == 0) {
        (void)seen.push_back({.pose = from_inverse_depth(h.poses[frame]),
                              .normalised = observations[end].normalised,
                              .sigma_normalised = observations[end].sigma_normalised});
      }
    }
    begin = end;
    if (seen.size() < 2) {
      continue;
    }
    const Result<TriangulatedPoint> point = triangulate(seen.view());
    if (point.ok() && point.value().p_T.norm() < kReachMax) {
      h.points_T[track] = point.value().p_T;
      h.known[track] = 1;
    }
  }
}

bool extend(std::span<const TrackObservation> observations,
            std::span<const double> times_s,
            int rounds,
            InitialHypothesis* hypothesis) {
  InitialHypothesis& h = *hypothesis;
  bool grown = false;
  add_points(observations, &h);
  for (int round = 0; round < rounds; ++round) {
    const std::array<std::uint8_t, limits::kInitialFrames> posed = h.posed;
    // On either side of each posed frame the nearest unposed one with data.
    for (int direction : {1, -1}) {
      const int frames = static_cast<int>(h.frames);
      bool open = false;
      for (int k = 0; k < frames; ++k) {
        const int f = direction > 0 ? k : frames - 1 - k;
        if (posed[static_cast<std::size_t>(f)] != 0) {
          open = true;
        } else if (open && h.posed[static_cast<std::size_t>(f)] == 0 &&
                   pose_frame(observations, times_s, f, &h)) {
          grown = true;
          open = false;
        }
      }
    }
    add_points(observations, &h);
  }
  return grown;
}

}  // namespace polhode
