#include "map/recognise.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "geometry/so3.hpp"
#include "map/blob_agreement.hpp"
#include "map/descriptor_table.hpp"

namespace polhode {
namespace {

/// Poses this near show the same aspect. A blob's orientation is good to 10 or 20 deg where the
/// light is another one, and the side that is seen differs from the keyframe's.
constexpr double kSameAspectHalfCosine = 0.966;  // 30 deg

/// Features are searched within this part of the radius about a pose that is known to 20 deg.
constexpr double kReachPart = 0.15;

/// So much of the radius about the map's middle, in the image plane z = 1.
double reach_of(const LocaliseInput& input, double part, const Pose& pose) {
  return std::max(input.options->search_floor_px / input.camera->focal_px(),
                  part * input.map->radius_mu / pose.to_camera(input.map->centre_T).z());
}

/// The pose by a feature and a view that look alike.
struct Vote {
  std::int32_t feature = -1;
  Eigen::Quaterniond q_CT = Eigen::Quaterniond::Identity();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< normalised, where it has the map's
  double log_depth = 0.0;                            ///< of that
  Eigen::Vector3d p_CT = Eigen::Vector3d::Zero();
  // What it rests on:
  std::int32_t landmark = -1;                      ///< slot
  Eigen::Vector2d seen = Eigen::Vector2d::Zero();  ///< the feature's image point, normalised
  double log_size = 0.0;                           ///< blob in the image over blob on the body
};

/// The view as it was, turned in the image and moved along the line of sight until its blob is the
/// feature.
Pose pose_by(const Feature& feature,
             const Landmark& landmark,
             const Feature& seen,
             const Pose& pose_seen) {
  const Eigen::Vector3d to = feature.normalised.homogeneous().normalized();
  const Eigen::Vector3d from = seen.normalised.homogeneous().normalized();
  const Eigen::AngleAxisd roll(static_cast<double>(feature.angle_rad - seen.angle_rad), to);
  const double depth = pose_seen.to_camera(landmark.p_T).z() * static_cast<double>(seen.scale_px) /
                       static_cast<double>(feature.scale_px);
  Pose pose;
  pose.R_CT = (roll * Eigen::Quaterniond::FromTwoVectors(from, to)) * pose_seen.R_CT;
  pose.p_CT = depth * feature.normalised.homogeneous() - pose.R_CT * landmark.p_T;
  return pose;
}

/// @param row  of the table, like the feature; -1: none.
void add_vote(const LocaliseInput& input,
              const DescriptorTable& table,
              std::size_t feature,
              std::int32_t row,
              std::vector<Vote>* votes) {
  if (row < 0) {
    return;
  }
  const Map& map = *input.map;
  const std::int32_t slot = table.landmark[static_cast<std::size_t>(row)];
  const Landmark& landmark = map.landmarks[static_cast<std::size_t>(slot)];
  const LandmarkView& view =
      landmark.views[static_cast<std::size_t>(table.view[static_cast<std::size_t>(row)])];
  const Feature* const before = feature_of_view(map, view);
  if (before == nullptr) {
    return;
  }
  const Feature& seen = (*input.features)[feature];
  const Pose pose = pose_by(seen, landmark, *before, map.keyframes[view.keyframe.index()].pose);
  const Eigen::Vector3d centre_C = pose.to_camera(map.centre_T);
  if (centre_C.z() > 0.0) {
    votes->push_back({.feature = static_cast<std::int32_t>(feature),
                      .q_CT = Eigen::Quaterniond(pose.R_CT),
                      .centre = centre_C.hnormalized(),
                      .log_depth = std::log(centre_C.z()),
                      .p_CT = pose.p_CT,
                      .landmark = slot,
                      .seen = seen.normalised,
                      .log_size = std::log(static_cast<double>(seen.scale_px) /
                                           (landmark.size_mu * input.camera->focal_px()))});
  }
}

std::vector<Vote> votes_of(const LocaliseInput& input, const DescriptorTable& table) {
  const std::vector<Neighbours> found = nearest_rows(table, *input.features);
  std::vector<Vote> votes;
  votes.reserve(2 * found.size());
  for (std::size_t f = 0; f < found.size(); ++f) {
    add_vote(input, table, f, found[f].nearest, &votes);
    add_vote(input, table, f, found[f].second, &votes);
  }
  return votes;
}

bool is_same_aspect(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return std::abs(a.dot(b)) > kSameAspectHalfCosine;
}

/// Do two votes mean one pose? A blob's size is good to a quarter.
bool agree(const Vote& a, const Vote& b, double radius) {
  constexpr double kLogDepth = 0.4;  // a factor of 1.5
  constexpr double kCentre = 0.35;   // of the radius: 30 deg about a blob halfway out, and more
  return is_same_aspect(a.q_CT, b.q_CT) && std::abs(a.log_depth - b.log_depth) < kLogDepth &&
         (a.centre - b.centre).squaredNorm() <
             kCentre * kCentre * radius * radius * std::exp(-2.0 * a.log_depth);
}

Pose pose_of(const Vote& vote) { return {.R_CT = vote.q_CT.toRotationMatrix(), .p_CT = vote.p_CT}; }

/// Does a vote's feature lie roughly where a pose has its landmark, as large as it has it?
bool supports(const Vote& vote, const Map& map, const Pose& pose, double reach) {
  constexpr double kLogSize = 0.5;  // a factor of 1.7
  const Landmark& landmark = map.landmarks[static_cast<std::size_t>(vote.landmark)];
  const Eigen::Vector3d p_C = pose.to_camera(landmark.p_T);
  return p_C.z() > 0.0 && (pose.R_CT * landmark.normal_T).dot(p_C) < 0.0 &&
         (p_C.hnormalized() - vote.seen).squaredNorm() < reach * reach &&
         std::abs(vote.log_size + std::log(p_C.z())) < kLogSize;
}

/// Calls `take` with the first vote of each feature that `counts` is true of.
template <typename Counts, typename Take>
void each_feature(const std::vector<Vote>& votes, const Counts& counts, const Take& take) {
  std::int32_t last = -1;
  for (const Vote& vote : votes) {  // in the order of features
    if (vote.feature != last && counts(vote)) {
      take(vote);
      last = vote.feature;
    }
  }
}

/// Number of features with a vote that `counts` is true of.
template <typename Counts>
int features_of(const std::vector<Vote>& votes, const Counts& counts) {
  int features = 0;
  each_feature(votes, counts, [&](const Vote& /*vote*/) { ++features; });
  return features;
}

/// The best `count` of the votes named, best first.
template <typename Score>
std::vector<std::size_t> best_of(const std::vector<std::size_t>& named,
                                 std::size_t count,
                                 const Score& score) {
  std::vector<std::pair<int, std::size_t>> scores;
  scores.reserve(named.size());
  for (const std::size_t i : named) {
    scores.emplace_back(-score(i), i);
  }
  std::sort(scores.begin(), scores.end());
  scores.resize(std::min(count, scores.size()));
  std::vector<std::size_t> order;
  order.reserve(scores.size());
  for (const auto& [minus_score, i] : scores) {
    order.push_back(i);
  }
  return order;
}

/// The first of the votes named, of each aspect a few: so that a body's other aspects are tried,
/// too, which may look the same.
std::vector<std::size_t> of_different_aspects(const std::vector<std::size_t>& named,
                                              const std::vector<Vote>& votes,
                                              std::size_t count) {
  constexpr int kAlike = 3;  // with two of eight in all, two of ten passes are recognised no more
  std::vector<std::size_t> chosen;
  for (const std::size_t i : named) {
    const auto alike = std::count_if(chosen.begin(), chosen.end(), [&](std::size_t k) {
      return is_same_aspect(votes[i].q_CT, votes[k].q_CT);
    });
    if (chosen.size() < count && alike < kAlike) {
      chosen.push_back(i);
    }
  }
  return chosen;
}

/// A pose fitted to the places of the votes' features that support it, which come nearer from
/// round to round. A vote has the side that its keyframe saw, up to 20 deg and more from this one;
/// the places of many show this one.
Pose fit_to_votes(const LocaliseInput& input, const std::vector<Vote>& votes, Pose pose) {
  constexpr int kRounds = 4;       // to a third in all, in which features are then searched
  constexpr double kNearer = 0.7;  // half of the area
  constexpr double kSigmas = 4.0;  // within reach of what is searched for
  std::vector<PoseObservation> observations;
  double part = kReachPart;
  for (int round = 0; round < kRounds; ++round, part *= kNearer) {
    const double reach = reach_of(input, part, pose);
    observations.clear();
    each_feature(
        votes,
        [&](const Vote& vote) { return supports(vote, *input.map, pose, reach); },
        [&](const Vote& vote) {
          const auto slot = static_cast<std::size_t>(vote.landmark);
          observations.push_back({.p_T = input.map->landmarks[slot].p_T,
                                  .normalised = vote.seen,
                                  .sigma_normalised = reach / kSigmas});
        });
    const std::vector<std::uint8_t> all(observations.size(), 1);
    const Result<AbsolutePose> fitted = refine_pose(observations, pose, all);
    if (!fitted) {
      return pose;
    }
    pose = fitted.value().pose;
  }
  return pose;
}

/// Poses that many votes mean, those first that most features support.
std::vector<Pose> poses_to_try(const LocaliseInput& input, const std::vector<Vote>& votes) {
  // Of 1600 votes so many are held against all others, and so many tried: 20 to 50 ms in all. With
  // five times as many hardly more frames are recognised.
  constexpr std::size_t kLooked = 150;
  constexpr std::size_t kTried = 12;
  std::vector<std::size_t> order(votes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  order = best_of(order, kLooked, [&](std::size_t i) {
    return features_of(votes,
                       [&](const Vote& v) { return agree(votes[i], v, input.map->radius_mu); });
  });
  order = best_of(order, kLooked, [&](std::size_t i) {
    const Pose pose = pose_of(votes[i]);
    const double reach = reach_of(input, kReachPart, pose);
    return features_of(votes, [&](const Vote& v) { return supports(v, *input.map, pose, reach); });
  });
  std::vector<Pose> poses;
  for (const std::size_t i : of_different_aspects(order, votes, kTried)) {
    poses.push_back(pose_of(votes[i]));
  }
  return poses;
}

/// A pose, and so many blobs that agree with it, of those that were tried.
struct Trials {
  const LocaliseInput* input = nullptr;
  const std::vector<Vote>* votes = nullptr;
  LocaliseScratch* scratch = nullptr;
  std::unique_ptr<LocalisedFrame> best = std::make_unique<LocalisedFrame>();
  int agreeing = 0;  ///< blobs, with the best one
  int rival = 0;     ///< with the best one elsewhere
};

/// @param out  working memory.
void try_pose(const Pose& pose, Trials* trials, LocalisedFrame* out) {
  const LocaliseInput& input = *trials->input;
  const Pose near = fit_to_votes(input, *trials->votes, pose);
  const double reach_px = reach_of(input, kReachPart / 3.0, near) * input.camera->focal_px();
  if (!localise_guided(input, near, reach_px, trials->scratch, out)) {
    return;
  }
  const int count = agreeing_blobs(input, *out);
  const bool same =
      trials->agreeing > 0 && is_same_aspect(trials->best->absolute.pose, out->absolute.pose);
  if (count > trials->agreeing) {
    trials->rival = same ? trials->rival : std::max(trials->rival, trials->agreeing);
    trials->agreeing = count;
    *trials->best = *out;
  } else if (!same) {
    trials->rival = std::max(trials->rival, count);
  }
}

/// The poses that bodies of two, three, four or six alike sides have as well, about each of the
/// landmarks' principal axes.
std::vector<Pose> turned_about_axes(const Map& map, const Pose& pose) {
  // Of two, three, four and six sides.
  constexpr std::array kTurns_deg = {60.0, 90.0, 120.0, 180.0, 240.0, 270.0, 300.0};
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Landmark& landmark : map.landmarks) {
    const Eigen::Vector3d arm = landmark.p_T - map.centre_T;
    scatter += landmark.used ? Eigen::Matrix3d(arm * arm.transpose()) : Eigen::Matrix3d::Zero();
  }
  const Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors();
  std::vector<Pose> poses;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double turn_deg : kTurns_deg) {
      Pose turned;
      turned.R_CT = pose.R_CT * so3_exp(turn_deg * M_PI / 180.0 * axes.col(axis));
      turned.p_CT = pose.to_camera(map.centre_T) - turned.R_CT * map.centre_T;
      poses.push_back(turned);
    }
  }
  return poses;
}

}  // namespace

bool is_same_aspect(const Pose& a, const Pose& b) {
  return is_same_aspect(Eigen::Quaterniond(a.R_CT), Eigen::Quaterniond(b.R_CT));
}

Result<int> recognise(const LocaliseInput& input,
                      const Pose* before,
                      LocaliseScratch* scratch,
                      LocalisedFrame* out) {
  const auto all = [](const Landmark&) { return true; };
  const DescriptorTable table = views_of(*input.map, input.stream, all);
  if (table.landmark.empty() || input.features->empty()) {
    return ErrorCode::kTooFewObservations;
  }
  const std::vector<Vote> votes = votes_of(input, table);
  std::vector<Pose> poses = poses_to_try(input, votes);
  if (before != nullptr) {
    poses.push_back(*before);
  }
  Trials trials{.input = &input, .votes = &votes, .scratch = scratch};
  for (const Pose& pose : poses) {
    try_pose(pose, &trials, out);
  }
  if (trials.agreeing >= kAgreeingBlobsMin) {
    const Pose found = trials.best->absolute.pose;
    for (const Pose& pose : turned_about_axes(*input.map, found)) {
      try_pose(pose, &trials, out);
    }
  }
  // Of a right pose two thirds of the inliers agree, of a like pattern's a third.
  const bool most_agree = 2 * trials.agreeing >= trials.best->absolute.inliers;
  if (trials.agreeing < kAgreeingBlobsMin || !most_agree ||
      !outnumbers(trials.agreeing, trials.rival)) {
    return ErrorCode::kNoConsensus;
  }
  take_matches(input, *trials.best, scratch, out);
  return trials.agreeing;
}

}  // namespace polhode
