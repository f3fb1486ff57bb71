#include "mask/follow.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/limited.hpp"
#include "base/wide.hpp"
#include "mask/behind.hpp"
#include "mask/edge_cut.hpp"
#include "mask/grown.hpp"
#include "mask/prior.hpp"
#include "mask/shrink.hpp"

namespace polhode {
namespace {

constexpr int kPatience = 5;

/// With a map evidence, and all that is said of it, is by so many working pixels: it is summed over
/// more, and keyframes' outlines are moved to edges. Done before one, a map's first outlines in a
/// room overlap by 0.5 instead of 0.8.
constexpr int kCoarseStep = 2;

/// The spacing of a body's texture, halved.
int closing_radius(const MaskState& s) { return std::max(2, s.points.whole().width / 160); }

/// What gaps are closed with. With a map a square, as that is separable; before one a disc: a map's
/// first poses are as good as the outlines that it begins with.
cv::Mat closing(const MaskState& s, int radius) {
  const int side = 2 * radius + 1;
  return has_map(s) ? cv::Mat::ones(side, side, CV_8UC1)
                    : cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(side, side));
}

/// A box in working pixels and what is certain.
cv::Rect with_certain(const cv::Rect& box, const MaskState& s) {
  const int step = s.evidence.step;
  const cv::Rect certain(s.certain_box.tl() * step, s.certain_box.size() * step);
  return s.certain.empty() ? box : (box | certain) & s.points.whole();
}

/// Fills `enclosed` with what the evidence encloses when gaps are closed.
/// @return the working pixels that it says anything of: none where nothing is enclosed.
cv::Rect enclose(int gap_radius_px, MaskState* s) {
  const int step = s->evidence.step;
  const cv::Rect region = with_certain(s->evidence.region, *s);
  const cv::Mat gap = closing(*s, gap_radius_px / step);
  const cv::Mat certain = s->certain_box.empty() ? cv::Mat() : s->certain;
  const bool found = find_outline(
      s->evidence.total, certain, coarser(region, step), gap, step, &s->scratch, &s->enclosed);
  return found ? region : cv::Rect();
}

void find_piece(MaskState* s) {
  s->outline.create(s->points.whole().size(), CV_8UC1);
  s->outline.setTo(0);
  const cv::Rect box = enclose(closing_radius(*s), s);
  if (has_map(*s)) {
    cv::bitwise_and(s->enclosed, s->reach, s->enclosed);
  }
  fill_from_cells(s->enclosed, s->evidence.step, box, &s->outline);
  s->found = cv::countNonZero(s->enclosed) > 0;
}

/// Adds what the evidence encloses when gaps twice as wide are closed, save where the background is
/// seen: a panel as gray as the ocean behind it shows in its grid alone. Where it comes into view
/// there are no landmarks yet, so their reach does not bound it.
void widen_outline(MaskState* s) {
  const cv::Rect box = enclose(2 * closing_radius(*s), s);
  cv::compare(s->evidence.total, static_cast<double>(kAgreement), s->open, cv::CMP_GE);
  cv::bitwise_and(s->enclosed, s->open, s->enclosed);
  s->added.create(s->outline.size(), CV_8UC1);
  fill_from_cells(s->enclosed, s->evidence.step, box, &s->added);
  cv::Mat outline = s->outline(box);
  cv::bitwise_or(outline, s->added(box), outline);
}

/// How far the edges may move an outline, in working pixels: first by cells of two, then by pixels.
int far_reach_px(const MaskState& s) { return std::max(kOutlineOff_px, s.outline.cols / 32); }
constexpr int kNearReach_px = 1;

/// Where the cuts ask for an opinion.
cv::Rect box_of_cuts(const MaskState& s) {
  const cv::Rect box = with_certain(cv::boundingRect(s.outline), s);
  return grown(box, far_reach_px(s) + kNearReach_px + 1) & s.points.whole();
}

/// Where edges are measured, and with it how high one is among them. Before a map by the outline's
/// own size: by the cuts' box, one of seven maps before a limb began a picture later and, with one
/// seed of five, was three times as far off.
cv::Rect box_of_edges(const MaskState& s) {
  if (has_map(s)) {
    return box_of_cuts(s);
  }
  const cv::Rect box = cv::boundingRect(s.outline);
  return grown(box, std::max(kOutlineOff_px, std::max(box.width, box.height) / 8)) &
         s.points.whole();
}

/// What speaks for the target in each of the evidence's pixels that the box holds, before the edges
/// are asked: these pictures, and with a map the nearness to landmarks. All of it is weak against
/// an even place's price of 6: what a moving target uncovers contradicts the background as much as
/// the target does, so motion is off by what has been uncovered, and only the edges of the picture
/// are where the target ends.
void form_opinion(const cv::Rect& box, MaskState* s) {
  constexpr float kEvidenceShare = 0.15F;
  constexpr float kEvidenceMin = -0.5F;  // places that look like the background agree by chance
  constexpr float kEvidenceMax = 1.5F;
  constexpr float kOutlineShare = 0.3F;
  constexpr float kMapShare = 0.25F;
  const bool by_map = has_map(*s);
  const auto near = static_cast<float>(std::max(3.0, 0.1 * s->radius_px));
  s->opinion.create(s->evidence.total.size(), CV_32FC1);
  cover_by_half(s->outline, s->opinion.size(), &s->cells);
  const cv::Rect part = coarser(box, s->evidence.step);
  widely([&] {
    for (int row = part.y; row < part.br().y; ++row) {
      const auto* evidence = s->evidence.total.ptr<float>(row);
      const auto* outline = s->cells.ptr<std::uint8_t>(row);
      auto* opinion = s->opinion.ptr<float>(row);
      for (int column = part.x; column < part.br().x; ++column) {
        opinion[column] = kEvidenceShare * limited(evidence[column], kEvidenceMin, kEvidenceMax) +
                          (outline[column] != 0 ? kOutlineShare : -kOutlineShare);
      }
      if (!by_map) {
        continue;
      }
      const auto* distance = s->distance.ptr<float>(row);
      for (int column = part.x; column < part.br().x; ++column) {
        opinion[column] += kMapShare * limited(1.0F - distance[column] / near, 0.0F, 1.0F);
      }
    }
  });
}

/// Where pictures are compared: about the target where it is known, and now and then everywhere.
cv::Rect region_of_interest(const MaskState& s) {
  const bool mapped = !s.certain.empty();
  const std::size_t everywhere_each = mapped ? 32 : 8;
  const cv::Rect whole = s.points.whole();
  if (!s.was_found || s.compared % everywhere_each == 0 || s.outline.size() != whole.size()) {
    return whole;
  }
  if (mapped) {
    return box_of_cuts(s);  // what is farther off no edge brings in
  }
  // Half of the target may still be missing.
  const cv::Rect box = cv::boundingRect(s.outline);
  return grown(box, std::max(16, std::max(box.width, box.height) / 4)) & whole;
}

/// Takes a picture in and compares it with the ones before. @return whether a background's motion
/// was found.
bool compare_pictures(const cv::Mat& gray,
                      const cv::Mat& reduced,
                      const MaskPrior& prior,
                      MaskState* s) {
  const bool first = add_picture(gray, reduced, &s->points);
  if (first) {
    clear(&s->background);
    clear(&s->evidence);
    clear(&s->background_model);
    s->compared = 0;
  }
  // Before a map each point counts: followed so, maps before the Earth begin one to three pictures
  // later.
  s->points.onwards = has_map(*s);
  follow_points(&s->points);
  size_evidence(s->points.whole().size(), prior.points_px.empty() ? 1 : kCoarseStep, &s->evidence);
  place_landmarks(prior, true, s);
  const FittedAges compared = s->evidence.longer ? FittedAges::kLonger : FittedAges::kShorter;
  const FittedAges ages = has_map(*s) ? compared : FittedAges::kBoth;
  const bool explained =
      explain_background(s->certain, s->evidence.step, ages, &s->points, &s->background);
  const cv::Rect region = region_of_interest(*s);
  weigh_motions(s->points, s->background, region, &s->evidence);
  place_prior(prior, s);
  choose_age(s->points, &s->background);
  ++s->compared;
  return explained;
}

/// Where the camera stands still what is beside the target is remembered: each time that the target
/// has moved on, so that a part of it that the outline lacks is not.
void remember_background(bool explained, MaskState* s) {
  if (!explained) {
    return;
  }
  if (!stands_still(s->background, s->points.whole().size())) {
    clear(&s->background_model);
  } else if (s->found && s->background.target_tracks >= kTracksEnough &&
             s->compared % s->background.age == 0) {
    learn_background(s->points.picture(0), s->outline, s->evidence.noise, &s->background_model);
  }
}

/// Before a map each point counts: by turns maps before a limb begin from less, and their outlines
/// overlap by 0.04 less.
void refill(MaskState* s) {
  const Refill later = has_map(*s) ? Refill::kByTurns : Refill::kBandAndTarget;
  refill_points(s->found ? cv::boundingRect(s->outline) : cv::Rect(),
                s->compared <= 1 ? Refill::kEverywhere : later,
                &s->points);
}

/// Fills `cells`: the mask's that are open by half.
void to_mask_cells(const cv::Size& size, MaskState* s) {
  s->added.create(s->points.whole().size(), CV_8UC1);
  fill_from_cells(s->open, s->evidence.step, s->points.whole(), &s->added);
  cover_by_half(s->added, size, &s->cells);
}

/// Lit cells that the outline covers by half and that do not agree with the background. The rim of
/// the body is no place for features: what is seen beside it changes as the body turns.
void open_lit_cells(MaskState* s, TargetMask* mask) {
  cv::compare(s->evidence.total, static_cast<double>(kAgreement), s->open, cv::CMP_GE);
  if (!s->certain.empty()) {
    // Between the landmarks of a body at rest before a background at rest everything agrees.
    cv::compare(s->distance, near_px(*s), s->cells, cv::CMP_LE);
    cv::bitwise_or(s->open, s->cells, s->open);
  }
  cv::bitwise_and(s->open, s->enclosed, s->open);
  if (!s->certain.empty()) {
    cv::bitwise_or(s->open, s->landmarks, s->open);
  }
  to_mask_cells(mask->cells.size(), s);
  cv::bitwise_and(s->cells, mask->cells, mask->cells);
  measure_cells(mask->region_px, mask);
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
  s->behind = options.tells_background() &&
              is_behind(mask->cells, cells_of_body(prior), s->behind, &s->scratch);
  if (!s->behind) {
    clear(s);
    return;
  }
  const bool explained = compare_pictures(gray, mask->levels, prior, s);
  s->unexplained = explained ? 0 : std::min(s->unexplained + 1, 2 * kPatience);
  find_piece(s);
  remember_background(explained, s);
  refill(s);
  if (!s->found && s->unexplained >= kPatience && s->points.stored > 1) {
    return;
  }
  open_lit_cells(s, mask);
}

void sharpen_outline(MaskState* s) {
  if (!s->behind || !s->found) {
    return;
  }
  widen_outline(s);
  const bool mapped = has_map(*s);
  const cv::Mat& picture = s->points.picture(0);
  const cv::Rect box = box_of_cuts(*s);
  form_opinion(box, s);
  if (mapped) {
    match_background(picture, s->evidence.noise, &s->background_model);
    add_appearance(picture,
                   s->outline,
                   s->background_model.matches,
                   box,
                   s->evidence.step,
                   &s->appearance_scratch,
                   &s->opinion);
  }
  refine_opinion(
      picture, s->outline, s->network, s->evidence.step, &s->refine_scratch, &s->opinion);
  measure_edges(picture, box_of_edges(*s), &s->edges);
  s->outline.copyTo(s->added);
  const int far_px = far_reach_px(*s);
  const CutOpinion opinion{
      .weight = s->opinion, .certain = s->certain, .cell_px = s->evidence.step};
  if (mapped) {
    cut_at_edges(s->edges, opinion, {.px = far_px, .cell_px = opinion.cell_px}, &s->outline);
    cut_at_edges(s->edges, opinion, {.px = kNearReach_px}, &s->outline);
  } else {
    // Outlines lack a side or hold a shadow, and looks would make more of it. Cut by cells, maps
    // before a limb begin later.
    cut_at_edges(s->edges, opinion, {.px = far_px}, &s->outline);
  }
  if (cv::boundingRect(s->outline).area() < kTargetAreaMin) {
    // Where all of a small body may be cut away and its edges are as steep as what is behind it,
    // nothing is what costs least.
    cv::swap(s->outline, s->added);
    return;
  }
  if (mapped) {
    remember_outline(s->outline, &s->evidence);
  }
  s->sharp = true;
}

void open_outline(const cv::Size& image_px, MaskState* s, TargetMask* mask) {
  if (!s->sharp || has_map(*s)) {
    return;
  }
  cv::compare(s->evidence.total, static_cast<double>(kAgreement), s->open, cv::CMP_GE);
  cover_by_half(s->outline, s->open.size(), &s->cells);
  cv::bitwise_and(s->open, s->cells, s->open);
  cv::dilate(s->open, s->open, cv::Mat());
  to_mask_cells(mask->cells.size(), s);
  s->cells.copyTo(mask->cells);
  measure_cells(cv::Rect(cv::Point(), image_px), mask);
}

void clear(MaskState* s) {
  clear(&s->points);  // and all that is compared goes with the first of them
  s->behind = false;
  s->found = false;
  s->sharp = false;
  s->unexplained = kPatience;
}

bool rules_out(const MaskState& s, float u_px, float v_px) {
  if (!s.sharp) {
    return false;
  }
  const cv::Point at = working_pixel({u_px, v_px}, s);
  constexpr int kSide = 2 * kOutlineOff_px + 1;
  const cv::Rect around =
      cv::Rect(at.x - kOutlineOff_px, at.y - kOutlineOff_px, kSide, kSide) & s.points.whole();
  return cv::countNonZero(s.outline(around)) == 0;
}

}  // namespace polhode
