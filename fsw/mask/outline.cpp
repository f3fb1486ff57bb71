#include "mask/outline.hpp"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "mask/grown.hpp"

namespace polhode {
namespace {

constexpr float kTargetEvidence = 0.3F;  // of sigmas a pixel over a window of 25
constexpr float kCertainEvidence = 6.0F;
constexpr double kPieceEvidenceMin = 250.0;

struct Piece {
  double evidence = 0.0;
  int left = std::numeric_limits<int>::max();
  int right = -1;
  int top = std::numeric_limits<int>::max();
  int bottom = -1;

  [[nodiscard]] cv::Rect box() const {
    return right < 0 ? cv::Rect() : cv::Rect(left, top, right - left + 1, bottom - top + 1);
  }
};

constexpr int kStep = 2;  // of the pixels that are asked what a piece weighs

/// Sum of positive evidence and extent by piece; the first is none.
std::vector<Piece> weigh_pieces(const cv::Mat& evidence,
                                const cv::Mat& certain,
                                const cv::Mat& labels,
                                int count) {
  std::vector<Piece> pieces(static_cast<std::size_t>(count));
  for (int row = 0; row < evidence.rows; row += kStep) {
    const auto* says = evidence.ptr<float>(row);
    const auto* label = labels.ptr<int>(row);
    const std::uint8_t* sure = certain.empty() ? nullptr : certain.ptr<std::uint8_t>(row);
    for (int column = 0; column < evidence.cols; column += kStep) {
      if (label[column] == 0) {
        continue;
      }
      Piece& piece = pieces[static_cast<std::size_t>(label[column])];
      const float weight = sure != nullptr && sure[column] != 0 ? kCertainEvidence : says[column];
      piece.evidence += kStep * kStep * static_cast<double>(std::max(0.0F, weight));
      piece.left = std::min(piece.left, column);
      piece.right = std::max(piece.right, column);
      piece.top = std::min(piece.top, row);
      piece.bottom = row;
    }
  }
  return pieces;
}

/// A twentieth of the evidence of the main piece, and nearer to it than a third of its size.
bool belongs(const Piece& piece, const Piece& main) {
  const cv::Rect box = main.box();
  const int reach = std::max(box.width, box.height) / 3;
  return piece.evidence > 0.05 * main.evidence && (grown(box, reach) & piece.box()).area() > 0;
}

/// Everything that the rim of the picture cannot be reached from.
void fill_holes(cv::Mat* outline, cv::Mat* flooded) {
  cv::copyMakeBorder(*outline, *flooded, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::floodFill(*flooded, cv::Point(0, 0), cv::Scalar(128));
  for (int row = 0; row < outline->rows; ++row) {
    const std::uint8_t* from = flooded->ptr<std::uint8_t>(row + 1) + 1;
    std::uint8_t* to = outline->ptr<std::uint8_t>(row);
    for (int column = 0; column < outline->cols; ++column) {
      to[column] = from[column] == 128 ? 0 : 255;
    }
  }
}

}  // namespace

bool find_outline(const cv::Mat& all_evidence,
                  const cv::Mat& all_certain,
                  const cv::Rect& region,
                  const cv::Mat& closing,
                  int step,
                  OutlineScratch* s,
                  cv::Mat* whole_outline) {
  whole_outline->create(all_evidence.size(), CV_8UC1);
  whole_outline->setTo(0);
  if (region.empty()) {
    return false;
  }
  const cv::Mat evidence = all_evidence(region);
  const cv::Mat certain = all_certain.empty() ? cv::Mat() : all_certain(region);
  cv::Mat outline = (*whole_outline)(region);
  cv::compare(evidence, static_cast<double>(kTargetEvidence), s->positive, cv::CMP_GT);
  cv::medianBlur(s->positive, s->positive, 3);  // single pixels are noise
  if (!certain.empty()) {
    cv::bitwise_or(s->positive, certain, s->positive);
  }
  cv::morphologyEx(s->positive, s->positive, cv::MORPH_CLOSE, closing);
  const int count = cv::connectedComponents(s->positive, s->labels, 8, CV_32S);
  const std::vector<Piece> pieces = weigh_pieces(evidence, certain, s->labels, count);
  const auto main =
      std::max_element(pieces.begin() + 1, pieces.end(), [](const Piece& a, const Piece& b) {
        return a.evidence < b.evidence;
      });
  const int pixels = step * step;
  if (count < 2 || pixels * main->evidence < kPieceEvidenceMin ||
      pixels * main->box().area() < kTargetAreaMin) {
    return false;
  }
  std::vector<std::uint8_t> keep(pieces.size(), 0);
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    keep[i] = belongs(pieces[i], *main) ? 255 : 0;
  }
  for (int row = 0; row < evidence.rows; ++row) {
    const int* label = s->labels.ptr<int>(row);
    std::uint8_t* to = outline.ptr<std::uint8_t>(row);
    for (int column = 0; column < evidence.cols; ++column) {
      to[column] = keep[static_cast<std::size_t>(label[column])];
    }
  }
  fill_holes(&outline, &s->flooded);
  return true;
}

}  // namespace polhode
