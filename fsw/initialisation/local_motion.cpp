#include "initialisation/local_motion.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "base/median.hpp"

namespace polhode {
namespace {

// An affine motion has three unknowns a coordinate; four times as many neighbours average their
// noise.
constexpr std::size_t kFitted = 12;
constexpr std::size_t kFittedMin = 6;
// Rounds of fitting and rejection.
constexpr int kRounds = 3;
// Neighbours farther off than three medians, and than a detection's error, belong to another
// motion.
constexpr double kOutlierMedians = 3.0;
constexpr double kOutlierMin_px = 1.0;
// Change of scale between two kept frames beyond which the neighbours are of another surface.
constexpr double kAreaMin = 0.3;
constexpr double kAreaMax = 3.0;

struct Correspondence {
  Eigen::Vector2d from_px = Eigen::Vector2d::Zero();  ///< from the track's place
  Eigen::Vector2d to_px = Eigen::Vector2d::Zero();
  bool fits = true;
};
using Correspondences = FixedVector<Correspondence, kFitted>;

/// The common shift of the neighbours, by medians: half of them may be wrong.
LocalMotion median_shift(const Correspondences& list) {
  FixedVector<double, kFitted> across;
  FixedVector<double, kFitted> down;
  for (const Correspondence& c : list) {
    (void)across.push_back(c.to_px.x() - c.from_px.x());
    (void)down.push_back(c.to_px.y() - c.from_px.y());
  }
  return {.place_px = {median(across.view()), median(down.view())}};
}

std::optional<LocalMotion> fit(const Correspondences& list) {
  // A weak prior towards no change, of one pixel squared: neighbours on a line do not constrain the
  // direction across it.
  Eigen::Matrix3d H = Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal();
  Eigen::Matrix<double, 3, 2> g = Eigen::Matrix<double, 3, 2>::Identity();
  std::size_t count = 0;
  for (const Correspondence& c : list) {
    if (c.fits) {
      const Eigen::Vector3d row(c.from_px.x(), c.from_px.y(), 1.0);
      H += row * row.transpose();
      g += row * c.to_px.transpose();
      ++count;
    }
  }
  const Eigen::Matrix<double, 3, 2> solution = H.inverse() * g;
  if (count < kFittedMin / 2 || !solution.allFinite()) {
    return std::nullopt;
  }
  return LocalMotion{.affine = solution.topRows<2>().transpose(),
                     .place_px = solution.row(2).transpose()};
}

void leave_out(const LocalMotion& motion, Correspondences* list) {
  FixedVector<double, kFitted> rest_px;
  for (const Correspondence& c : *list) {
    (void)rest_px.push_back((motion.affine * c.from_px + motion.place_px - c.to_px).norm());
  }
  FixedVector<double, kFitted> sorted = rest_px;
  const double limit_px = std::max(kOutlierMin_px, kOutlierMedians * median(sorted.view()));
  for (std::size_t i = 0; i < list->size(); ++i) {
    (*list)[i].fits = rest_px[i] <= limit_px;
  }
}

}  // namespace

Neighbours nearest_tracks(std::span<const TrackPlaces> tracks,
                          std::size_t track,
                          std::size_t frame) {
  const Eigen::Vector2f own = tracks[track].px[frame];
  const auto distance2 = [&](std::size_t i) { return (tracks[i].px[frame] - own).squaredNorm(); };
  Neighbours nearest;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (i == track || !tracks[i].has(frame)) {
      continue;
    }
    if (nearest.full()) {
      if (distance2(i) >= distance2(nearest.back())) {
        continue;
      }
      nearest.pop_back();
    }
    (void)nearest.push_back(i);
    for (std::size_t k = nearest.size() - 1;
         k > 0 && distance2(nearest[k - 1]) > distance2(nearest[k]);
         --k) {
      std::swap(nearest[k - 1], nearest[k]);
    }
  }
  return nearest;
}

std::optional<LocalMotion> local_motion(std::span<const TrackPlaces> tracks,
                                        const Neighbours& neighbours,
                                        std::size_t track,
                                        std::size_t from_frame,
                                        std::size_t to_frame) {
  const Eigen::Vector2d own = tracks[track].px[from_frame].cast<double>();
  Correspondences list;
  for (const std::size_t i : neighbours) {
    if (!list.full() && tracks[i].has(to_frame)) {
      (void)list.push_back({.from_px = tracks[i].px[from_frame].cast<double>() - own,
                            .to_px = tracks[i].px[to_frame].cast<double>()});
    }
  }
  if (list.size() < kFittedMin) {
    return std::nullopt;
  }
  std::optional<LocalMotion> motion = median_shift(list);
  for (int round = 0; round < kRounds; ++round) {
    leave_out(*motion, &list);
    motion = fit(list);
    if (!motion) {
      return std::nullopt;
    }
  }
  const double area = motion->affine.determinant();
  return area > kAreaMin && area < kAreaMax ? motion : std::nullopt;
}

}  // namespace polhode
