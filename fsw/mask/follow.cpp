#include "mask/follow.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/avx2_dispatch.hpp"
#include "base/limited.hpp"
#include "mask/behind.hpp"
#include "mask/edge_cut.hpp"
#include "mask/grown.hpp"
#include "mask/prior.hpp"
#include "mask/shrink.hpp"

namespace polhode {
namespace {

// Images in a row without a motion of the background before everything lit is the target. Chosen:
// larger keeps the mask closed for longer, smaller opens it after a few badly tracked images.
constexpr int kUnexplainedMax = 5;

// Working pixels of a cell of the log-odds with a map: their window is wider than that, and
// outlines are moved to edges afterwards. Not before a map: its first outlines in a room overlapped
// by 0.5 instead of 0.8 (decision 0010).
constexpr int kCoarseStep = 2;

/// Radius of the closing: half the spacing of a body's texture, 4 px of 640. Chosen; larger closes
/// over the background between parts, smaller leaves panels as grids.
int closing_radius(const MaskState& s) { return std::max(2, s.points.whole().width / 160); }

/// Structuring element of the closing. With a map a square, which is separable. Before one a disc,
/// as a map's first poses depend on its first outlines.
cv::Mat closing(const MaskState& s, int radius) {
  const int side = 2 * radius + 1;
  return has_map(s) ? cv::Mat::ones(side, side, CV_8UC1)
                    : cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(side, side));
}

/// A box in working pixels, enlarged to hold the seeds.
cv::Rect with_seeds(const cv::Rect& box, const MaskState& s) {
  const int step = s.foreground.step;
  const cv::Rect seeds(s.map.seeds_box.tl() * step, s.map.seeds_box.size() * step);
  return s.map.seeds.empty() ? box : (box | seeds) & s.points.whole();
}

/// Fills `enclosed` with the cells that the log-odds enclose when gaps are closed.
/// @return the working pixels that it covers: none where nothing is enclosed.
cv::Rect enclose(int gap_radius_px, MaskState* s) {
  const int step = s->foreground.step;
  const cv::Rect region = with_seeds(s->foreground.region, *s);
  const bool found = find_outline({.log_odds = s->foreground.log_odds,
                                   .seeds = s->map.seeds_box.empty() ? cv::Mat() : s->map.seeds,
                                   .region = coarser(region, step),
                                   .closing = closing(*s, gap_radius_px / step),
                                   .step = step},
                                  &s->scratch.outline,
                                  &s->scratch.enclosed);
  return found ? region : cv::Rect();
}

void find_piece(MaskState* s) {
  s->outline.create(s->points.whole().size(), CV_8UC1);
  s->outline.setTo(0);
  const cv::Rect box = enclose(closing_radius(*s), s);
  if (has_map(*s)) {
    cv::bitwise_and(s->scratch.enclosed, s->map.reach, s->scratch.enclosed);
  }
  fill_from_cells(s->scratch.enclosed, s->foreground.step, box, &s->outline);
  s->found = cv::countNonZero(s->scratch.enclosed) > 0;
}

/// Adds the cells that the log-odds enclose when gaps twice as wide are closed (decision 0007),
/// except where the background is seen. A panel as gray as the ocean behind it shows by its grid
/// alone. The landmarks' reach is no bound, as a face that comes into view has no landmarks yet.
void widen_outline(MaskState* s) {
  const cv::Rect box = enclose(2 * closing_radius(*s), s);
  MaskScratch& scratch = s->scratch;
  cv::compare(s->foreground.log_odds, static_cast<double>(kAgreement), scratch.open, cv::CMP_GE);
  cv::bitwise_and(scratch.enclosed, scratch.open, scratch.enclosed);
  scratch.added.create(s->outline.size(), CV_8UC1);
  fill_from_cells(scratch.enclosed, s->foreground.step, box, &scratch.added);
  cv::Mat outline = s->outline(box);
  cv::bitwise_or(outline, scratch.added(box), outline);
}

/// Reach of the first cut, in working pixels: 1/32 of the width, and at least the outline's error.
/// With 1/48 overlaps are 0.007 lower in a room, and no time is saved (decision 0011).
int far_reach_px(const MaskState& s) { return std::max(kOutlineOff_px, s.outline.cols / 32); }
// Reach of the second cut, by pixels: half a cell of the first one.
constexpr int kNearReach_px = kCoarseStep / 2;

/// Box of the unary cost: the reach of both cuts, and the neighbours of those pixels.
cv::Rect box_of_cuts(const MaskState& s) {
  const cv::Rect box = with_seeds(cv::boundingRect(s.outline), s);
  return grown(box, far_reach_px(s) + kNearReach_px + 1) & s.points.whole();
}

/// Box of the edges and of their mean square. Before a map an eighth of the outline's size around
/// it. Measured over box_of_cuts, one of seven maps before a limb began an image later; with one
/// seed of five it was three times as far off.
cv::Rect box_of_edges(const MaskState& s) {
  if (has_map(s)) {
    return box_of_cuts(s);
  }
  const cv::Rect box = cv::boundingRect(s.outline);
  return grown(box, std::max(kOutlineOff_px, std::max(box.width, box.height) / 8)) &
         s.points.whole();
}

/// The unary cost of each cell within the box: positive for the target. By the log-odds, the
/// outline and, with a map, the nearness to landmarks. All are weak against the boundary cost of an
/// even place, 6 (edge_cut.hpp): a strip of background that the target has just uncovered
/// contradicts the background's model as the target does, so only image edges give the outline.
void form_unary_cost(const cv::Rect& box, MaskState* s) {
  // Decision 0007. With 0.35 the outline keeps the uncovered strip: overlap 0.88 instead of 0.93.
  constexpr float kLogOddsShare = 0.15F;
  // Places that look like the background agree by chance. With -2, landmarks on the background rose
  // from 3 of 1411 to 12 of 1363 before the Earth (decision 0007).
  constexpr float kLogOddsMin = -0.5F;
  // Five times kTargetLogOdds. Chosen: larger lets motion alone fix the outline.
  constexpr float kLogOddsMax = 1.5F;
  // With 0.2 overlaps are within 0.02; 0.4 keeps the uncovered strip (decision 0007).
  constexpr float kOutlineShare = 0.3F;
  // At a landmark. Chosen (decision 0007): under the outline's, as some landmarks are wrong.
  constexpr float kMapShare = 0.25F;
  // Distance at which a landmark has no effect, in the body's radius, and its least in px. Chosen:
  // larger draws the outline beyond the silhouette, smaller leaves gaps between landmarks.
  constexpr double kNearPart = 0.1;
  constexpr double kNearDistanceMin_px = 3.0;
  const bool by_map = has_map(*s);
  const auto near = static_cast<float>(std::max(kNearDistanceMin_px, kNearPart * s->map.radius_px));
  cv::Mat& unary_cost = s->scratch.cell_values;
  cv::Mat& outline_cells = s->scratch.cells;
  unary_cost.create(s->foreground.log_odds.size(), CV_32FC1);
  cover_by_half(s->outline, unary_cost.size(), &outline_cells);
  const cv::Rect part = coarser(box, s->foreground.step);
  with_avx2([&] {
    for (int row = part.y; row < part.br().y; ++row) {
      const auto* log_odds = s->foreground.log_odds.ptr<float>(row);
      const auto* outline = outline_cells.ptr<std::uint8_t>(row);
      auto* cost = unary_cost.ptr<float>(row);
      for (int column = part.x; column < part.br().x; ++column) {
        cost[column] = kLogOddsShare * limited(log_odds[column], kLogOddsMin, kLogOddsMax) +
                       (outline[column] != 0 ? kOutlineShare : -kOutlineShare);
      }
      if (!by_map) {
        continue;
      }
      const auto* distance = s->map.distance.ptr<float>(row);
      for (int column = part.x; column < part.br().x; ++column) {
        cost[column] += kMapShare * limited(1.0F - distance[column] / near, 0.0F, 1.0F);
      }
    }
  });
}

/// Region of the comparison: around the target where it is known, and now and then the whole image.
cv::Rect region_of_interest(const MaskState& s) {
  // Images from one comparison of the whole image to the next (decision 0013): more saves time and
  // finds missing parts later.
  constexpr std::size_t kEverywhereWithMap = 32;
  constexpr std::size_t kEverywhereBefore = 8;
  // Least margin before a map. Chosen: larger costs time, smaller misses parts of a small target.
  constexpr int kMarginMin_px = 16;
  const bool has_seeds = !s.map.seeds.empty();
  const std::size_t everywhere_each = has_seeds ? kEverywhereWithMap : kEverywhereBefore;
  const cv::Rect whole = s.points.whole();
  if (!s.was_found || s.compared % everywhere_each == 0 || s.outline.size() != whole.size()) {
    return whole;
  }
  if (has_seeds) {
    return box_of_cuts(s);  // the cuts move the outline no farther
  }
  // A quarter of its size more on each side, as the outline may still lack parts of the target.
  const cv::Rect box = cv::boundingRect(s.outline);
  return grown(box, std::max(kMarginMin_px, std::max(box.width, box.height) / 4)) & whole;
}

/// Stores an image and compares it with the ones before. @return whether a background's motion was
/// found.
bool compare_images(const cv::Mat& gray,
                    const cv::Mat& reduced,
                    const MaskPrior& prior,
                    MaskState* s) {
  const bool first = add_image(gray, reduced, &s->points);
  if (first) {
    clear(&s->background);
    clear(&s->foreground);
    clear(&s->background_model);
    s->compared = 0;
  }
  // Not before a map: with predicted searches, maps before the Earth begin one to three images
  // later (decision 0013).
  s->points.predicted = has_map(*s);
  follow_points(&s->points);
  resize_log_odds(
      s->points.whole().size(), prior.points_px.empty() ? 1 : kCoarseStep, &s->foreground);
  place_landmarks(prior, true, s);
  const FittedAges compared = s->foreground.longer ? FittedAges::kLonger : FittedAges::kShorter;
  const FittedAges ages = has_map(*s) ? compared : FittedAges::kBoth;
  const bool explained =
      explain_background(s->map.seeds, s->foreground.step, ages, &s->points, &s->background);
  const cv::Rect region = region_of_interest(*s);
  update_log_odds(s->points, s->background, region, &s->foreground);
  place_prior(prior, s);
  choose_age(s->points, &s->background);
  ++s->compared;
  return explained;
}

/// Updates the background model where the camera stands still. Only once per interval in which the
/// target has moved: a part of it that the outline misses is then not taken for background.
void remember_background(bool explained, MaskState* s) {
  if (!explained) {
    return;
  }
  if (!stands_still(s->background, s->points.whole().size())) {
    clear(&s->background_model);
  } else if (s->found && s->background.target_tracks >= kTracksEnough &&
             s->compared % s->background.age == 0) {
    learn_background(s->points.image(0), s->outline, s->foreground.noise, &s->background_model);
  }
}

/// Adds points to follow. By turns only where there is a map: without one, outlines of a target
/// before the Earth's limb overlap by 0.04 less (decision 0013).
void refill(MaskState* s) {
  const Refill later = has_map(*s) ? Refill::kByTurns : Refill::kBandAndTarget;
  refill_points(s->found ? cv::boundingRect(s->outline) : cv::Rect(),
                s->compared <= 1 ? Refill::kEverywhere : later,
                &s->points);
}

/// Fills `cells`: the mask's cells of which half is open.
void to_mask_cells(const cv::Size& size, MaskState* s) {
  MaskScratch& scratch = s->scratch;
  scratch.added.create(s->points.whole().size(), CV_8UC1);
  fill_from_cells(scratch.open, s->foreground.step, s->points.whole(), &scratch.added);
  cover_by_half(scratch.added, size, &scratch.cells);
}

/// Keeps lit cells that the outline covers by half and that do not agree with the background.
/// Features at the silhouette are left out: what is seen beside it changes as the body rotates.
void open_lit_cells(MaskState* s, TargetMask* mask) {
  MaskScratch& scratch = s->scratch;
  cv::compare(s->foreground.log_odds, static_cast<double>(kAgreement), scratch.open, cv::CMP_GE);
  if (!s->map.seeds.empty()) {
    // On a body at rest before a background at rest all pixels agree with the background: cells
    // between its landmarks are opened by distance alone.
    cv::compare(s->map.distance, near_px(*s), scratch.cells, cv::CMP_LE);
    cv::bitwise_or(scratch.open, scratch.cells, scratch.open);
  }
  cv::bitwise_and(scratch.open, scratch.enclosed, scratch.open);
  if (!s->map.seeds.empty()) {
    cv::bitwise_or(scratch.open, s->map.landmark_discs, scratch.open);
  }
  to_mask_cells(mask->cells.size(), s);
  cv::bitwise_and(scratch.cells, mask->cells, mask->cells);
  measure_cells(mask->region_px, mask);
}

/// Before a lit background: does the outline cover so much of the image's border that it includes
/// background?
bool covers_border(const MaskState& s) {
  // Chosen: two fifths of a side. A body that enters the image covers less.
  constexpr double kShareMax = 0.1;
  if (!s.behind || !s.found || s.outline.empty()) {
    return false;
  }
  const cv::Mat& o = s.outline;
  const int covered = cv::countNonZero(o.row(0)) + cv::countNonZero(o.row(o.rows - 1)) +
                      cv::countNonZero(o.col(0)) + cv::countNonZero(o.col(o.cols - 1));
  return covered > kShareMax * 2.0 * (o.rows + o.cols);
}

}  // namespace

void follow_target(const cv::Mat& gray,
                   const MaskPrior& prior,
                   const MaskOptions& options,
                   MaskState* s,
                   TargetMask* mask) {
  s->was_found = s->found;
  s->found = false;
  s->sharp = false;
  s->behind = options.separates_background() &&
              is_behind(mask->cells, cells_of_body(prior), s->behind, &s->scratch.outline);
  if (!s->behind) {
    clear(s);
    return;
  }
  const bool explained = compare_images(gray, mask->levels, prior, s);
  // Bounded, as all counts over kUnexplainedMax have the same effect.
  s->unexplained = explained ? 0 : std::min(s->unexplained + 1, 2 * kUnexplainedMax);
  find_piece(s);
  remember_background(explained, s);
  refill(s);
  if (is_open(*s)) {
    return;
  }
  open_lit_cells(s, mask);
}

bool is_open(const MaskState& s) {
  return s.behind && !s.found && s.unexplained >= kUnexplainedMax && s.points.stored > 1;
}

bool may_be_background(const MaskState& s) {
  // Without motion of the background an image does not separate it from the target: the outline is
  // then the last one, background included.
  if (covers_border(s) || (s.behind && s.found && s.unexplained > 0)) {
    return true;
  }
  // Least points at the border, as in a background's layer: fewer may be of a boom that crosses it.
  constexpr auto kAtBorderMin = static_cast<std::ptrdiff_t>(BackgroundMotion::kLayerTracksMin);
  const cv::Rect whole = s.points.whole();
  const cv::Rect inside(
      whole.width / 8, whole.height / 8, whole.width * 3 / 4, whole.height * 3 / 4);
  return is_open(s) &&
         std::count_if(s.points.tracks.begin(), s.points.tracks.end(), [&](const MaskTrack& track) {
           return track.count > 1 && !inside.contains(cv::Point(track.now()));
         }) >= kAtBorderMin;
}

void sharpen_outline(MaskState* s) {
  if (!s->behind || !s->found) {
    return;
  }
  widen_outline(s);
  const bool mapped = has_map(*s);
  const cv::Mat& image = s->points.image(0);
  const cv::Rect box = box_of_cuts(*s);
  form_unary_cost(box, s);
  MaskScratch& scratch = s->scratch;
  cv::Mat& unary_cost = scratch.cell_values;
  const int step = s->foreground.step;
  if (mapped) {
    match_background(image, s->foreground.noise, &s->background_model);
    const cv::Mat& matches = s->background_model.matches;
    add_appearance({image, s->outline, matches, box, step}, &scratch.appearance, &unary_cost);
  }
  measure_edges(image, box_of_edges(*s), &scratch.edges);
  s->outline.copyTo(scratch.added);
  const int far_px = far_reach_px(*s);
  const UnaryCost cost{.value = unary_cost, .seeds = s->map.seeds, .cell_px = step};
  if (mapped) {
    cut_at_edges(scratch.edges, cost, {.px = far_px, .cell_px = step}, &s->outline);
    cut_at_edges(scratch.edges, cost, {.px = kNearReach_px}, &s->outline);
  } else {
    // No appearance here: as long as there is no map, outlines lack a face or include a shadow, and
    // it would add to that (decision 0008). A first cut by cells would delay maps where
    // the Earth's limb is behind the target.
    cut_at_edges(scratch.edges, cost, {.px = far_px}, &s->outline);
  }
  if (cv::boundingRect(s->outline).area() < kTargetAreaMin) {
    // A small body with no steeper edges than its background: the empty outline would be cheapest.
    cv::swap(s->outline, scratch.added);
    return;
  }
  if (mapped) {
    remember_outline(s->outline, &s->foreground);
  }
  s->sharp = true;
}

void open_outline(const cv::Size& image_px, MaskState* s, TargetMask* mask) {
  if (!s->sharp || has_map(*s)) {
    return;
  }
  MaskScratch& scratch = s->scratch;
  cv::compare(s->foreground.log_odds, static_cast<double>(kAgreement), scratch.open, cv::CMP_GE);
  cover_by_half(s->outline, scratch.open.size(), &scratch.cells);
  cv::bitwise_and(scratch.open, scratch.cells, scratch.open);
  cv::dilate(scratch.open, scratch.open, cv::Mat());
  to_mask_cells(mask->cells.size(), s);
  scratch.cells.copyTo(mask->cells);
  measure_cells(cv::Rect(cv::Point(), image_px), mask);
}

void clear(MaskState* s) {
  clear(&s->points);  // the next image then counts as the first, which clears the comparison
  s->behind = false;
  s->found = false;
  s->sharp = false;
  s->unexplained = kUnexplainedMax;
}

bool rules_out(const MaskState& s, float u_px, float v_px) {
  if (!s.sharp) {
    return false;
  }
  const cv::Point at = working_pixel({u_px, v_px}, s);
  constexpr int kSide = 2 * kOutlineOff_px + 1;  // the outline's error on both sides of the pixel
  const cv::Rect around =
      cv::Rect(at.x - kOutlineOff_px, at.y - kOutlineOff_px, kSide, kSide) & s.points.whole();
  return cv::countNonZero(s.outline(around)) == 0;
}

}  // namespace polhode
