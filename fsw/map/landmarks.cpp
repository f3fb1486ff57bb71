#include "map/landmarks.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/avx2_dispatch.hpp"
#include "features/match.hpp"
#include "geometry/epipolar.hpp"
#include "map/localise.hpp"
#include "solve/triangulate.hpp"

namespace polhode {
namespace {

// Gate of new pairs about their epipolar line. The line contains the drift between the two
// keyframes. A gate as narrow as the noise accepts only pairs whose errors agree with that drift,
// which fixes the drift in the map. Twice that gate halves the effect; the adjustment then rejects
// wrong pairs, nearly a tenth of which are beyond 3 sigma. For two views chi-square has one degree
// of freedom.
constexpr double kLineSigma = 6.0;
constexpr double kChi2Pair = kLineSigma * kLineSigma;
constexpr double kObservationSigma =
    3.0;  // reprojection gate of further observations of a landmark
constexpr std::size_t kPartners = 6;

double sigma_normalised(const Feature& feature, double focal_px) {
  return static_cast<double>(feature.sigma_px) / focal_px;
}

/// Angle at the body between the directions to two cameras.
double view_angle_rad(const Pose& a, const Pose& b, const Eigen::Vector3d& centre_T) {
  const Eigen::Vector3d to_a = (a.camera_T() - centre_T).normalized();
  const Eigen::Vector3d to_b = (b.camera_T() - centre_T).normalized();
  return std::acos(std::clamp(to_a.dot(to_b), -1.0, 1.0));
}

/// Have the two been adjusted against each other? True of neighbours in time, and of keyframes that
/// a loop closure connects. Between others the epipolar line is off by the drift, and a match along
/// it is a match by chance.
bool connected(const Keyframe& a, const Keyframe& b) {
  // A pose from fewer common landmarks is off by more than a line's gate. Chosen.
  constexpr int kSharedMin = 15;
  if (std::max(a.number, b.number) - std::min(a.number, b.number) <= kRecentKeyframes) {
    return true;
  }
  std::array<bool, limits::kLandmarks> seen{};
  for (std::size_t i = 0; i < a.features.size(); ++i) {
    if (a.landmark_of[i].valid()) {
      seen[a.landmark_of[i].index()] = true;
    }
  }
  int shared = 0;
  for (std::size_t i = 0; i < b.features.size(); ++i) {
    shared += b.landmark_of[i].valid() && seen[b.landmark_of[i].index()] ? 1 : 0;
  }
  return shared >= kSharedMin;
}

/// Partner keyframes, best first: their views differ by enough for depth and little enough for
/// descriptors. The ideal is 8 deg, between small depth errors and matching descriptors.
FixedVector<KeyframeId, limits::kKeyframes> partners_of(KeyframeId keyframe,
                                                        const CreateOptions& options,
                                                        const Map& map) {
  constexpr double kIdeal_rad = 0.14;  // 8 deg
  constexpr double kMost_rad = 0.6;    // 34 deg: beyond it descriptors hardly match
  const Keyframe& own = map.keyframes[keyframe.index()];
  std::array<double, limits::kKeyframes> merit{};
  FixedVector<KeyframeId, limits::kKeyframes> partners;
  for (const KeyframeId id : keyframes_by_age(map)) {
    const double angle = view_angle_rad(own.pose, map.keyframes[id.index()].pose, map.centre_T);
    if (id == keyframe || angle < options.parallax_min_rad || angle > kMost_rad ||
        !connected(own, map.keyframes[id.index()])) {
      continue;
    }
    merit[id.index()] = std::abs(std::log(angle / kIdeal_rad));
    (void)partners.push_back(id);
  }
  std::stable_sort(partners.begin(), partners.end(), [&](KeyframeId a, KeyframeId b) {
    return merit[a.index()] < merit[b.index()];
  });
  partners.resize(std::min(partners.size(), kPartners));
  return partners;
}

/// Features without a landmark, at places without a feature that has one.
/// @cost  few neighbours of each feature by u, not all of them.
void list_free(const Keyframe& keyframe,
               FixedVector<std::int32_t, limits::kFeatures>* taken,
               FixedVector<std::int32_t, limits::kFeatures>* out) {
  const auto at = [&](std::int32_t i) -> const Feature& {
    return keyframe.features[static_cast<std::size_t>(i)];
  };
  taken->clear();
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (keyframe.landmark_of[i].valid()) {
      (void)taken->push_back(static_cast<std::int32_t>(i));
    }
  }
  std::sort(taken->begin(), taken->end(), [&](std::int32_t a, std::int32_t b) {
    return at(a).u_px < at(b).u_px;
  });
  out->clear();
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const Feature& f = keyframe.features[i];
    bool free = !keyframe.landmark_of[i].valid();
    const std::int32_t* near = std::lower_bound(
        taken->begin(), taken->end(), f.u_px - 1.0F, [&](std::int32_t other, float u_px) {
          return at(other).u_px < u_px;
        });
    for (; free && near != taken->end() && at(*near).u_px - f.u_px < 1.0F; ++near) {
      free =
          !(std::abs(f.u_px - at(*near).u_px) < 1.0F && std::abs(f.v_px - at(*near).v_px) < 1.0F);
    }
    if (free) {
      (void)out->push_back(static_cast<std::int32_t>(i));
    }
  }
}

/// Fills the table that a search along lines reads for each free feature of the partner.
void prepare_lines(const Keyframe& partner,
                   const Eigen::Matrix3d& E,
                   double focal_px,
                   CreateScratch* scratch) {
  LineTable& lines = scratch->lines;
  for (std::size_t k = 0; k < scratch->free_b.size(); ++k) {
    const Feature& f = partner.features[static_cast<std::size_t>(scratch->free_b[k])];
    const Eigen::Vector3d line_a = E.transpose() * f.normalised.homogeneous();
    const double sigma = sigma_normalised(f, focal_px);
    lines.x[k] = f.normalised.x();
    lines.y[k] = f.normalised.y();
    lines.variance[k] = sigma * sigma;
    lines.gradient2[k] = line_a.head<2>().squaredNorm();
  }
}

/// Lists the features whose Sampson error is within the gate, both squared. Plain loops of constant
/// length over plain numbers, which the compiler vectorises.
void list_near(const Eigen::Vector3d& line_b,
               double own_variance,
               std::size_t count,
               LineTable* lines) {
  const double a = line_b.x();
  const double b = line_b.y();
  const double c = line_b.z();
  const double own_gradient2 = a * a + b * b;
  lines->near.clear();
  for (std::size_t begin = 0; begin < count; begin += LineTable::kGrain) {
    std::array<std::int64_t, LineTable::kGrain> inside{};
    std::int64_t any = 0;
    for (std::size_t i = 0; i < LineTable::kGrain; ++i) {
      const std::size_t k = begin + i;
      const double error = lines->x[k] * a + lines->y[k] * b + c;
      const double gate = kLineSigma * kLineSigma * (own_variance + lines->variance[k]) *
                          (own_gradient2 + lines->gradient2[k]);
      inside[i] = error * error > gate ? 0 : 1;
      any |= inside[i];
    }
    if (any == 0) {
      continue;  // most groups of kGrain features have none near the line
    }
    for (std::size_t i = 0; i < LineTable::kGrain && begin + i < count; ++i) {
      if (inside[i] != 0) {
        (void)lines->near.push_back(static_cast<std::int32_t>(begin + i));
      }
    }
  }
}

/// Best partner of a feature along its epipolar line.
NearestFeature search_line(const Feature& wanted,
                           const Keyframe& partner,
                           const Eigen::Matrix3d& E,
                           double focal_px,
                           CreateScratch* scratch) {
  NearestFeature best;
  const double own_sigma = sigma_normalised(wanted, focal_px);
  const Eigen::Vector3d line_b = E * wanted.normalised.homogeneous();
  list_near(line_b, own_sigma * own_sigma, scratch->free_b.size(), &scratch->lines);
  for (const std::int32_t k : scratch->lines.near) {
    const std::int32_t index = scratch->free_b[static_cast<std::size_t>(k)];
    const Feature& f = partner.features[static_cast<std::size_t>(index)];
    const float ratio = wanted.scale_px / f.scale_px;
    if (ratio < 0.5F || ratio > 2.0F) {
      continue;
    }
    keep_nearest(index,
                 distance2(wanted.descriptor, f.descriptor),
                 partner.features.view(),
                 kSamePlace_px,
                 &best);
  }
  return best;
}

RayObservation observation(const Keyframe& keyframe, std::int32_t feature, double focal_px) {
  const Feature& f = keyframe.features[static_cast<std::size_t>(feature)];
  return {.pose = keyframe.pose,
          .normalised = f.normalised,
          .sigma_normalised = sigma_normalised(f, focal_px)};
}

/// Triangulates a matched pair; nothing where the point is not of this body.
bool acceptable(const TriangulatedPoint& point, const CreateOptions& options, const Map& map) {
  // A body is compact: a point beyond twice the radius that contains 90 % of its landmarks is a
  // mismatch.
  constexpr double kReach = 2.0;
  return point.chi2 < kChi2Pair && point.parallax_rad > options.parallax_min_rad &&
         (point.p_T - map.centre_T).norm() < kReach * map.radius_mu &&
         std::sqrt(point.covariance_T.trace()) < map.radius_mu;
}

struct FeatureIn {
  KeyframeId keyframe;
  std::int32_t feature = -1;
};

void create_pair(const FeatureIn& a,
                 const FeatureIn& b,
                 const CreateOptions& options,
                 double focal_px,
                 Map* map) {
  const std::array<RayObservation, 2> pair{
      observation(map->keyframes[a.keyframe.index()], a.feature, focal_px),
      observation(map->keyframes[b.keyframe.index()], b.feature, focal_px)};
  const Result<TriangulatedPoint> point = triangulate(pair);
  if (!point || !acceptable(point.value(), options, *map)) {
    return;
  }
  const LandmarkId id = add_landmark(map);
  if (!id.valid()) {
    return;
  }
  Landmark& landmark = map->landmarks[id.index()];
  landmark.p_T = point.value().p_T;
  landmark.created_keyframe = map->keyframes[a.keyframe.index()].number;
  add_observation(a.keyframe, static_cast<std::size_t>(a.feature), id, map);
  add_observation(b.keyframe, static_cast<std::size_t>(b.feature), id, map);
}

/// For each free feature of the partner the keyframe's own one, in scratch->best_of_b; -1: none.
void match_partner(const Keyframe& own,
                   const Keyframe& partner,
                   const CreateOptions& options,
                   double focal_px,
                   CreateScratch* scratch) {
  list_free(own, &scratch->taken, &scratch->free_a);
  list_free(partner, &scratch->taken, &scratch->free_b);
  RelativePose motion = relative_pose(own.pose, partner.pose);
  motion.p_ba.normalize();
  const Eigen::Matrix3d E = essential_matrix(motion);
  prepare_lines(partner, E, focal_px, scratch);
  scratch->best_of_b.fill(-1);
  scratch->distance_of_b.fill(std::numeric_limits<std::int32_t>::max());
  const double ratio2 = options.ratio_max * options.ratio_max;
  for (const std::int32_t index : scratch->free_a) {
    const NearestFeature best = with_avx2([&] {
      return search_line(
          own.features[static_cast<std::size_t>(index)], partner, E, focal_px, scratch);
    });
    if (best.feature < 0 || best.nearest2 > kDistance2Max || best.nearest2 > ratio2 * best.rival2) {
      continue;
    }
    const auto f = static_cast<std::size_t>(best.feature);
    if (best.nearest2 < scratch->distance_of_b[f]) {
      scratch->distance_of_b[f] = best.nearest2;
      scratch->best_of_b[f] = index;
    }
  }
}

/// Does the keyframe lie between the landmark's first and last keyframe, or at most
/// kRecentKeyframes before or after them? Else there is drift between keyframe and landmark.
bool of_same_stretch(const Landmark& landmark, const Keyframe& keyframe) {
  return keyframe.number + kRecentKeyframes >= landmark.created_keyframe &&
         keyframe.number <= landmark.seen_keyframe + kRecentKeyframes;
}

/// Searches for one landmark among the free features of one keyframe.
std::int32_t find_in(const Landmark& landmark,
                     const Keyframe& keyframe,
                     const FeatureGrid& grid,
                     const CameraModel& camera) {
  Eigen::Vector2d pixel;
  if (!should_be_seen(landmark, keyframe.pose, camera, &pixel)) {
    return -1;
  }
  // 3 sigma of the features are 1 to 2 px; the rest is for the young landmark's own error.
  constexpr double kReach_px = 6.0;
  std::array<std::int32_t, 32> near{};
  const std::size_t count = grid.find(pixel.x(), pixel.y(), kReach_px, near);
  NearestFeature best;
  for (std::size_t k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(near[k]);
    const Feature& f = keyframe.features[i];
    const double off_px = std::hypot(pixel.x() - static_cast<double>(f.u_px),
                                     pixel.y() - static_cast<double>(f.v_px));
    if (keyframe.landmark_of[i].valid() ||
        off_px > kObservationSigma * std::sqrt(2.0) * static_cast<double>(f.sigma_px)) {
      continue;
    }
    for (const LandmarkView& view : landmark.views) {
      const int d2 = distance2(view.descriptor, f.descriptor);
      if (d2 < best.nearest2) {
        best.nearest2 = d2;
        best.feature = near[k];
      }
    }
  }
  return best.nearest2 <= kDistance2Max ? best.feature : -1;
}

}  // namespace

int create_landmarks(KeyframeId keyframe,
                     const CreateOptions& options,
                     const CameraModel& camera,
                     CreateScratch* scratch,
                     Map* map) {
  const std::int32_t before = map->next_landmark_number;
  const double focal_px = camera.focal_px();
  for (const KeyframeId partner : partners_of(keyframe, options, *map)) {
    match_partner(map->keyframes[keyframe.index()],
                  map->keyframes[partner.index()],
                  options,
                  focal_px,
                  scratch);
    for (const std::int32_t index : scratch->free_b) {
      const std::int32_t best = scratch->best_of_b[static_cast<std::size_t>(index)];
      if (best >= 0) {
        create_pair({keyframe, best}, {partner, index}, options, focal_px, map);
      }
    }
  }
  return map->next_landmark_number - before;
}

int extend_landmarks(std::int32_t first_number, const CameraModel& camera, Map* map) {
  FixedVector<LandmarkId, limits::kLandmarks> young;
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    if (map->landmarks[i].used && map->landmarks[i].number >= first_number) {
      (void)young.push_back(LandmarkId::from_index(i));
    }
  }
  int associated = 0;
  FeatureGrid grid;
  std::array<bool, limits::kLandmarks> seen{};
  for (const KeyframeId id : keyframes_by_age(*map)) {
    const Keyframe& keyframe = map->keyframes[id.index()];
    if (std::none_of(young.begin(), young.end(), [&](LandmarkId landmark) {
          return of_same_stretch(map->landmarks[landmark.index()], keyframe);
        })) {
      continue;
    }
    grid.build(keyframe.features.view(), camera.width_px, camera.height_px);
    seen.fill(false);
    for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
      if (keyframe.landmark_of[i].valid()) {
        seen[keyframe.landmark_of[i].index()] = true;
      }
    }
    for (const LandmarkId landmark : young) {
      if (seen[landmark.index()] || !of_same_stretch(map->landmarks[landmark.index()], keyframe)) {
        continue;
      }
      const std::int32_t feature = with_avx2(
          [&] { return find_in(map->landmarks[landmark.index()], keyframe, grid, camera); });
      if (feature >= 0) {
        add_observation(id, static_cast<std::size_t>(feature), landmark, map);
        ++associated;
      }
    }
  }
  return associated;
}

}  // namespace polhode
