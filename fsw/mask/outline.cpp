#include "mask/outline.hpp"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "mask/foreground.hpp"
#include "mask/grown.hpp"

namespace polhode {
namespace {

// Log-odds of a seed: the bound of all log-odds.
constexpr float kSeedLogOdds = ForegroundState::kLogOddsMax;
// Least sum of a target over working pixels. Chosen: kTargetAreaMin pixels with 2.5 each. Larger
// loses small or slow targets, smaller takes noise for one.
constexpr double kPieceLogOddsMin = 250.0;
// Least sum of a separate part of the target, relative to the main piece's. Chosen; larger loses
// booms, smaller adds noise.
constexpr double kPartMin = 0.05;

struct Piece {
  double log_odds = 0.0;
  int left = std::numeric_limits<int>::max();
  int right = -1;
  int top = std::numeric_limits<int>::max();
  int bottom = -1;

  [[nodiscard]] cv::Rect box() const {
    return right < 0 ? cv::Rect() : cv::Rect(left, top, right - left + 1, bottom - top + 1);
  }
};

// Step of rows and columns in the sums: a quarter of the time, and a piece has many pixels.
constexpr int kOutlineStep = 2;

/// Sum of positive log-odds and extent by piece; entry 0 is of no piece.
std::vector<Piece> weigh_pieces(const cv::Mat& log_odds,
                                const cv::Mat& seeds,
                                const cv::Mat& labels,
                                int count) {
  std::vector<Piece> pieces(static_cast<std::size_t>(count));
  for (int row = 0; row < log_odds.rows; row += kOutlineStep) {
    const auto* of_row = log_odds.ptr<float>(row);
    const auto* label = labels.ptr<int>(row);
    const std::uint8_t* seed = seeds.empty() ? nullptr : seeds.ptr<std::uint8_t>(row);
    for (int column = 0; column < log_odds.cols; column += kOutlineStep) {
      if (label[column] == 0) {
        continue;
      }
      Piece& piece = pieces[static_cast<std::size_t>(label[column])];
      const float weight = seed != nullptr && seed[column] != 0 ? kSeedLogOdds : of_row[column];
      piece.log_odds += kOutlineStep * kOutlineStep * static_cast<double>(std::max(0.0F, weight));
      piece.left = std::min(piece.left, column);
      piece.right = std::max(piece.right, column);
      piece.top = std::min(piece.top, row);
      piece.bottom = row;
    }
  }
  return pieces;
}

/// Is a piece large enough and close enough to the main one? Closer than a third of that one's
/// size: chosen, as bodies' parts stand apart by less than they are long.
bool belongs(const Piece& piece, const Piece& main) {
  const cv::Rect box = main.box();
  const int reach = std::max(box.width, box.height) / 3;
  return piece.log_odds > kPartMin * main.log_odds && (grown(box, reach) & piece.box()).area() > 0;
}

/// Fills holes: sets everything that cannot be reached from the image border.
void fill_holes(cv::Mat* outline, cv::Mat* flooded) {
  cv::copyMakeBorder(*outline, *flooded, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  constexpr int kReached = 128;  // any level but 0 and 255, the outline's
  cv::floodFill(*flooded, cv::Point(0, 0), cv::Scalar(kReached));
  for (int row = 0; row < outline->rows; ++row) {
    const std::uint8_t* from = flooded->ptr<std::uint8_t>(row + 1) + 1;
    std::uint8_t* to = outline->ptr<std::uint8_t>(row);
    for (int column = 0; column < outline->cols; ++column) {
      to[column] = from[column] == kReached ? 0 : 255;
    }
  }
}

}  // namespace

bool find_outline(const OutlineInput& input, OutlineScratch* s, cv::Mat* whole_outline) {
  const cv::Rect& region = input.region;
  whole_outline->create(input.log_odds.size(), CV_8UC1);
  whole_outline->setTo(0);
  if (region.empty()) {
    return false;
  }
  const cv::Mat log_odds = input.log_odds(region);
  const cv::Mat seeds = input.seeds.empty() ? cv::Mat() : input.seeds(region);
  cv::Mat outline = (*whole_outline)(region);
  cv::compare(log_odds, static_cast<double>(kTargetLogOdds), s->positive, cv::CMP_GT);
  cv::medianBlur(s->positive, s->positive, 3);  // single pixels are noise
  if (!seeds.empty()) {
    cv::bitwise_or(s->positive, seeds, s->positive);
  }
  cv::morphologyEx(s->positive, s->positive, cv::MORPH_CLOSE, input.closing);
  const int count = cv::connectedComponents(s->positive, s->labels, 8, CV_32S);
  const std::vector<Piece> pieces = weigh_pieces(log_odds, seeds, s->labels, count);
  const auto main =
      std::max_element(pieces.begin() + 1, pieces.end(), [](const Piece& a, const Piece& b) {
        return a.log_odds < b.log_odds;
      });
  const int pixels = input.step * input.step;
  if (count < 2 || pixels * main->log_odds < kPieceLogOddsMin ||
      pixels * main->box().area() < kTargetAreaMin) {
    return false;
  }
  std::vector<std::uint8_t> keep(pieces.size(), 0);
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    keep[i] = belongs(pieces[i], *main) ? 255 : 0;
  }
  for (int row = 0; row < log_odds.rows; ++row) {
    const int* label = s->labels.ptr<int>(row);
    std::uint8_t* to = outline.ptr<std::uint8_t>(row);
    for (int column = 0; column < log_odds.cols; ++column) {
      to[column] = keep[static_cast<std::size_t>(label[column])];
    }
  }
  fill_holes(&outline, &s->flooded);
  return true;
}

}  // namespace polhode
