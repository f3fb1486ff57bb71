#include "mask/follow.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace polhode {
namespace {

// Two fifths of the picture's rim: the Earth behind half of the picture lights half of it. Before
// photographs of a body on a stand, which reaches the rim (up to 0.36), there is no motion to be told
// apart and much of the body to be lost.
constexpr double kRimLitMin = 0.4;
constexpr int kPatience = 5;

/// Part of the outermost cells that are lit.
double lit_rim(const cv::Mat& cells) {
  const int lit = cv::countNonZero(cells.row(0)) + cv::countNonZero(cells.row(cells.rows - 1)) +
                  cv::countNonZero(cells.col(0)) + cv::countNonZero(cells.col(cells.cols - 1));
  return static_cast<double>(lit) / (2.0 * (cells.rows + cells.cols));
}

/// Discs about the landmarks, and how far the body can reach beyond them: a new side comes into
/// view, and landmarks do not sit on its rim.
void place_prior(const MaskPrior& prior, MaskState* s) {
  if (prior.points_px.empty()) {
    s->certain.release();
    s->reach.release();
    return;
  }
  const auto scale = static_cast<float>(1.0 / s->background.decimation);
  const double radius = prior.radius_px * static_cast<double>(scale);
  const int disc = std::max(1, static_cast<int>(std::lround(0.05 * radius)));
  const auto reach = static_cast<float>(std::max(6.0, 0.35 * radius));
  s->near_px = std::max(2.0, 0.15 * radius);
  const cv::Size size = s->background.evidence.size();
  s->certain.create(size, CV_8UC1);
  s->certain.setTo(0);
  for (const cv::Point2f& p : prior.points_px) {
    const cv::Point at(static_cast<int>(std::lround((p.x + 0.5F) * scale - 0.5F)),
                       static_cast<int>(std::lround((p.y + 0.5F) * scale - 0.5F)));
    cv::circle(s->certain, at, disc, cv::Scalar(255), cv::FILLED);
  }
  cv::bitwise_not(s->certain, s->distance);
  cv::distanceTransform(s->distance, s->scratch.distance, cv::DIST_L2, 3, CV_32F);
  cv::compare(s->scratch.distance, static_cast<double>(reach), s->reach, cv::CMP_LE);
}

void find_piece(MaskState* s) {
  s->found = find_outline(s->background.evidence, s->certain, &s->scratch, &s->outline);
  if (!s->reach.empty()) {
    cv::bitwise_and(s->outline, s->reach, s->outline);
  }
}

/// What speaks for the target in each pixel before the edges are asked. Without a map: the evidence
/// so far, and the outline that was made of it. With a map the evidence's memory, which trails
/// behind what moves, counts for little: the nearness to landmarks and this picture alone decide.
void form_opinion(double radius, MaskState* s) {
  const BackgroundState& b = s->background;
  const bool by_map = !s->certain.empty();
  const auto near = static_cast<float>(std::max(2.0, 0.1 * radius));
  s->opinion.create(b.evidence.size(), CV_32FC1);
  for (int row = 0; row < s->opinion.rows; ++row) {
    const auto* evidence = b.evidence.ptr<float>(row);
    const auto* instant = b.instant.ptr<float>(row);
    const auto* distance = by_map ? s->scratch.distance.ptr<float>(row) : nullptr;
    const std::uint8_t* outline = s->outline.ptr<std::uint8_t>(row);
    auto* opinion = s->opinion.ptr<float>(row);
    for (int column = 0; column < s->opinion.cols; ++column) {
      if (by_map) {
        const float nearness = std::clamp(1.0F - distance[column] / near, -1.0F, 1.0F);
        opinion[column] = 0.15F * evidence[column] + 1.5F * instant[column] + 0.8F * nearness;
      } else {
        opinion[column] = 0.5F * evidence[column] + (outline[column] != 0 ? 0.6F : -0.6F);
      }
    }
  }
}

/// Where this picture agrees with the background's motion, textured as it is: what the target has
/// just left, or never was. A quarter more agreement than contradiction over 5 x 5 pixels.
void find_agreement(MaskState* s) {
  constexpr double kAgreement = -0.25;
  cv::blur(s->background.instant, s->opinion, cv::Size(5, 5));
  cv::compare(s->opinion, kAgreement, s->agreeing, cv::CMP_LT);
  // A turning body agrees now and then, where it moves little: much evidence stands for five
  // pictures.
  constexpr double kMuchEvidence = 4.5;
  cv::compare(s->background.evidence, kMuchEvidence, s->cells, cv::CMP_LT);
  cv::bitwise_and(s->agreeing, s->cells, s->agreeing);
}

/// Lit cells that the outline covers by half and that do not agree with the background. The rim of
/// the body is no place for features: what is seen beside it changes as the body turns.
void to_cells(MaskState* s, TargetMask* mask) {
  find_agreement(s);
  cv::bitwise_not(s->agreeing, s->agreeing);
  if (!s->certain.empty()) {
    // Between the landmarks of a body at rest before a background at rest everything agrees.
    cv::compare(s->scratch.distance, s->near_px, s->cells, cv::CMP_LE);
    cv::bitwise_or(s->agreeing, s->cells, s->agreeing);
  }
  cv::bitwise_and(s->agreeing, s->outline, s->agreeing);
  cv::resize(s->agreeing, s->cells, mask->cells.size(), 0.0, 0.0, cv::INTER_AREA);
  cv::threshold(s->cells, s->cells, 127.0, 255.0, cv::THRESH_BINARY);
  cv::bitwise_and(s->cells, mask->cells, mask->cells);
  const cv::Rect cells = cv::boundingRect(mask->cells);
  constexpr int kCell_px = TargetMask::kCell_px;
  mask->region_px &= cv::Rect(
      cells.x * kCell_px, cells.y * kCell_px, cells.width * kCell_px, cells.height * kCell_px);
  mask->coverage =
      static_cast<double>(cv::countNonZero(mask->cells)) / static_cast<double>(mask->cells.total());
}

}  // namespace

void follow_target(const cv::Mat& gray,
                   const MaskPrior& prior,
                   const MaskOptions& options,
                   MaskState* s,
                   TargetMask* mask) {
  find_target(gray, options, mask);
  s->found = false;
  s->sharp = false;
  s->behind = options.enabled && options.background && lit_rim(mask->cells) > kRimLitMin;
  if (!s->behind) {
    clear(&s->background);
    s->unexplained = kPatience;
    return;
  }
  add_picture(gray, &s->background);
  place_prior(prior, s);
  const bool explained = compare_pictures(s->certain, &s->background);
  s->unexplained = explained ? 0 : std::min(s->unexplained + 1, 2 * kPatience);
  find_piece(s);
  if (!s->found && s->unexplained >= kPatience && s->background.stored > 1) {
    return;
  }
  to_cells(s, mask);
}

void sharpen_outline(const MaskPrior& prior, MaskState* s) {
  if (!s->behind || s->background.stored == 0) {
    return;
  }
  place_prior(prior, s);
  find_piece(s);
  if (s->found) {
    form_opinion(prior.radius_px / s->background.decimation, s);
    cut_at_edges(s->background.pictures[s->background.newest], s->opinion, s->certain, &s->outline);
    s->sharp = true;
  }
}

}  // namespace polhode
