#include "mask/prior.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mask/grown.hpp"

namespace polhode {
namespace {

// Reach of a body beyond its landmarks, in its radius: a new face comes into view, and landmarks do
// not lie on the silhouette. Chosen; larger lets the background in, smaller cuts parts off.
constexpr double kReach = 0.35;
constexpr double kReachMin_px = 6.0;  // chosen: for a body so small that outlines' errors matter

// A disc around a landmark, in the body's radius. Chosen: larger opens the mask beyond the body.
constexpr double kDiscRadius = 0.05;

// Nearer to a landmark than this is target, in the body's radius, and its least. Chosen; larger
// fills gaps that are background, smaller leaves even panels open.
constexpr double kNear = 0.15;
constexpr double kNearMin_px = 2.0;

/// Distance to the pixels of `set`, within a box, in working pixels. Outside of the box: far.
/// @param step working pixels per pixel of `set`, along a side.
void distance_within(
    const cv::Mat& set, const cv::Rect& box, int step, OutlineScratch* s, cv::Mat* distance) {
  constexpr double kFar = 1E4;  // over the diagonal of any working image
  distance->create(set.size(), CV_32FC1);
  distance->setTo(kFar);
  cv::Mat part = (*distance)(box);
  cv::bitwise_not(set(box), s->positive);
  constexpr int kChamfer = 3;  // the fastest; off by a few percent, less than the uncertainty of
                               // the reach
  cv::distanceTransform(s->positive, part, cv::DIST_L2, kChamfer, CV_32F);
  part *= static_cast<double>(step);
}

/// Adds the cells between landmarks that are close together to the seeds, where the log-odds do not
/// indicate background.
void close_gaps(const cv::Rect& box, MaskState* s) {
  cv::Mat& cells = s->scratch.cells;
  cv::Mat& gap_distance = s->scratch.cell_values;
  cv::Mat& seeds = s->map.seeds;
  cv::compare(s->map.distance, near_px(*s), cells, cv::CMP_LE);
  cv::bitwise_not(cells, cells);
  distance_within(cells, box, s->foreground.step, &s->scratch.outline, &gap_distance);
  cv::compare(gap_distance(box), near_px(*s), cells(box), cv::CMP_GT);
  cv::bitwise_or(seeds(box), cells(box), seeds(box));
  cv::compare(s->foreground.log_odds(box), static_cast<double>(kAgreement), cells(box), cv::CMP_GT);
  cv::bitwise_and(seeds(box), cells(box), seeds(box));
}

}  // namespace

cv::Rect cells_of_body(const MaskPrior& prior) {
  if (prior.points_px.empty()) {
    return {};
  }
  const auto reach = static_cast<float>(kReach * prior.radius_px);
  const cv::Point2f corner(reach, reach);
  const auto cell_of = [](const cv::Point2f& p_px) {
    const cv::Point2f cell = p_px / static_cast<float>(TargetMask::kCell_px);
    return cv::Point(cvFloor(cell.x), cvFloor(cell.y));
  };
  cv::Rect cells;
  for (const cv::Point2f& p_px : prior.points_px) {
    const cv::Rect around(cell_of(p_px - corner), cell_of(p_px + corner) + cv::Point(1, 1));
    cells = cells.empty() ? around : cells | around;
  }
  return cells;
}

bool has_map(const MaskState& s) { return !s.map.reach.empty(); }

cv::Point working_pixel(const cv::Point2f& p_px, const MaskState& s) {
  const auto scale = static_cast<float>(1.0 / s.points.decimation);
  return {static_cast<int>(std::lround((p_px.x + 0.5F) * scale - 0.5F)),
          static_cast<int>(std::lround((p_px.y + 0.5F) * scale - 0.5F))};
}

void place_landmarks(const MaskPrior& prior, bool contradicted_too, MaskState* s) {
  if (prior.points_px.empty()) {
    s->map.seeds.release();
    return;
  }
  const double radius = prior.radius_px / s->points.decimation;
  const int step = s->foreground.step;
  const int disc = std::max(1, static_cast<int>(std::lround(kDiscRadius * radius / step)));
  const cv::Rect whole(cv::Point(), s->foreground.log_odds.size());
  s->map.seeds.create(whole.size(), CV_8UC1);
  s->map.seeds.setTo(0);
  for (const cv::Point2f& p_px : prior.points_px) {
    const cv::Point at = working_pixel(p_px, *s) / step;
    if (contradicted_too ||
        (whole.contains(at) && s->foreground.log_odds.at<float>(at) > kAgreement)) {
      cv::circle(s->map.seeds, at, disc, cv::Scalar(255), cv::FILLED);
    }
  }
  s->map.seeds_box = cv::boundingRect(s->map.seeds);
}

double near_px(const MaskState& s) { return std::max(kNearMin_px, kNear * s.map.radius_px); }

void place_prior(const MaskPrior& prior, MaskState* s) {
  place_landmarks(prior, false, s);
  if (s->map.seeds.empty() || s->map.seeds_box.empty()) {
    s->map.seeds.release();  // the images contradict all landmarks: the pose is wrong
    s->map.reach.release();
    return;
  }
  s->map.radius_px = prior.radius_px / s->points.decimation;
  const double reach = std::max(kReachMin_px, kReach * s->map.radius_px);
  // Two cells more: for the division's rest, and one beyond the reach.
  const int margin = static_cast<int>(reach) / s->foreground.step + 2;
  const cv::Rect box = grown(s->map.seeds_box, margin) & cv::Rect(cv::Point(), s->map.seeds.size());
  distance_within(s->map.seeds, box, s->foreground.step, &s->scratch.outline, &s->map.distance);
  cv::compare(s->map.distance, reach, s->map.reach, cv::CMP_LE);
  // Without the landmarks' discs where there is enough motion, which gives the finer outline:
  // overlap 0.86 and 0.90 on small `earth` and `paper_2d`, with the discs 0.81 and 0.87 (decision
  // 0006).
  s->map.seeds.copyTo(s->map.landmark_discs);
  if (s->background.target_tracks >= kTracksEnough) {
    s->map.seeds.setTo(0);
    s->map.seeds_box = {};
  } else {
    close_gaps(box, s);
    s->map.seeds_box = cv::boundingRect(s->map.seeds);
  }
}

}  // namespace polhode
