#include "mask/outline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

#include "base/assert.hpp"

namespace polhode {
namespace {

constexpr float kTargetEvidence = 0.3F;  // of sigmas a pixel over a window of 25
constexpr float kCertainEvidence = 6.0F;
constexpr int kPieceAreaMin = 100;  // working pixels; a target that small carries no map
constexpr double kPieceEvidenceMin = 250.0;

cv::Mat disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * radius + 1, 2 * radius + 1));
}

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

/// Sum of positive evidence and extent by piece; the first is none. Takes a quarter of OpenCV's statistics.
std::vector<Piece> weigh_pieces(const cv::Mat& evidence,
                                const cv::Mat& certain,
                                const cv::Mat& labels,
                                int count) {
  std::vector<Piece> pieces(static_cast<std::size_t>(count));
  for (int row = 0; row < evidence.rows; ++row) {
    const auto* says = evidence.ptr<float>(row);
    const auto* label = labels.ptr<int>(row);
    const std::uint8_t* sure = certain.empty() ? nullptr : certain.ptr<std::uint8_t>(row);
    for (int column = 0; column < evidence.cols; ++column) {
      if (label[column] == 0) {
        continue;
      }
      Piece& piece = pieces[static_cast<std::size_t>(label[column])];
      const float weight = sure != nullptr && sure[column] != 0 ? kCertainEvidence : says[column];
      piece.evidence += static_cast<double>(std::max(0.0F, weight));
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
  const cv::Rect grown(
      box.x - reach, box.y - reach, box.width + 2 * reach, box.height + 2 * reach);
  return piece.evidence > 0.05 * main.evidence && (grown & piece.box()).area() > 0;
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

/// Inverse of the mean square step between neighbours, of both directions together: a step of that
/// size costs 1/e of an even place.
double step_falloff(const cv::Mat& gray) {
  std::int64_t squares = 1;
  for (int row = 0; row + 1 < gray.rows; ++row) {
    const auto* here = gray.ptr<std::uint8_t>(row);
    const auto* below = gray.ptr<std::uint8_t>(row + 1);
    for (int column = 0; column + 1 < gray.cols; ++column) {
      const int right = here[column] - here[column + 1];
      const int down = here[column] - below[column];
      squares += right * right + down * down;
    }
  }
  return static_cast<double>(gray.total()) / static_cast<double>(squares);
}

// Whole numbers, and coarse ones: paths of the flow fill up together, in less than half of the time that real numbers take.
using Graph = cv::detail::GCGraph<int>;

constexpr double kPricePerOpinion = 2.0;
constexpr int kEven = 12;  // price of cutting an even place
constexpr int kCertain = 1000;

/// Price of calling a pixel background; negative: of calling it target. What is at the box's rim
/// and outside of the outline is background.
int price_at(const cv::Mat& opinion,
             const cv::Mat& certain,
             const cv::Mat& outline,
             cv::Point at) {
  if (!certain.empty() && certain.at<std::uint8_t>(at) != 0) {
    return kCertain;
  }
  const bool rim =
      at.y == 0 || at.x == 0 || at.y + 1 == opinion.rows || at.x + 1 == opinion.cols;
  return rim && outline.at<std::uint8_t>(at) == 0
             ? -kCertain
             : cvRound(kPricePerOpinion * static_cast<double>(opinion.at<float>(at)));
}

void add_price(int node, int price, Graph* graph) {
  graph->addTermWeights(node, std::max(price, 0), std::max(-price, 0));
}

/// Pixels near the outline, where it may be moved to: numbered in `nodes`, the others -1.
int number_band(const cv::Mat& outline, int reach_px, cv::Mat* nodes) {
  const cv::Mat square = cv::Mat::ones(2 * reach_px + 1, 2 * reach_px + 1, CV_8UC1);
  cv::Mat grown;
  cv::Mat shrunk;
  cv::dilate(outline, grown, square);
  cv::erode(outline, shrunk, square);
  nodes->create(outline.size(), CV_32SC1);
  int count = 0;
  for (int row = 0; row < outline.rows; ++row) {
    for (int column = 0; column < outline.cols; ++column) {
      const bool open = grown.at<std::uint8_t>(row, column) != shrunk.at<std::uint8_t>(row, column);
      nodes->at<int>(row, column) = open ? count++ : -1;
    }
  }
  return count;
}

void add_places(const cv::Mat& opinion,
                const cv::Mat& certain,
                const cv::Mat& outline,
                const cv::Mat& nodes,
                Graph* graph) {
  for (int row = 0; row < opinion.rows; ++row) {
    for (int column = 0; column < opinion.cols; ++column) {
      if (nodes.at<int>(row, column) >= 0) {
        add_price(graph->addVtx(), price_at(opinion, certain, outline, {column, row}), graph);
      }
    }
  }
}

/// Price of a cut between neighbours by the step between them: the less, the larger it is.
std::array<int, 256> tie_prices(const cv::Mat& gray) {
  const double falloff = step_falloff(gray);
  std::array<int, 256> prices{};
  for (std::size_t step = 0; step < prices.size(); ++step) {
    const auto levels = static_cast<double>(step);
    prices[step] = cvRound(kEven * std::exp(-falloff * levels * levels));
  }
  return prices;
}

/// What lies beyond the band stays as it is: a cut from it is a price of the pixel beside it.
void tie_neighbours(const cv::Mat& gray,
                    const cv::Mat& outline,
                    const cv::Mat& nodes,
                    Graph* graph) {
  const std::array<int, 256> prices = tie_prices(gray);
  const auto tie = [&](cv::Point a, cv::Point b) {
    const int node_a = nodes.at<int>(a);
    const int node_b = nodes.at<int>(b);
    if (node_a < 0 && node_b < 0) {
      return;
    }
    const int step = std::abs(gray.at<std::uint8_t>(a) - gray.at<std::uint8_t>(b));
    const int price = prices[static_cast<std::size_t>(step)];
    if (node_a >= 0 && node_b >= 0) {
      graph->addEdges(node_a, node_b, price, price);
      return;
    }
    const bool target = outline.at<std::uint8_t>(node_a < 0 ? a : b) != 0;
    add_price(std::max(node_a, node_b), target ? price : -price, graph);
  };
  for (int row = 0; row < gray.rows; ++row) {
    for (int column = 0; column < gray.cols; ++column) {
      if (column > 0) {
        tie({column, row}, {column - 1, row});
      }
      if (row > 0) {
        tie({column, row}, {column, row - 1});
      }
    }
  }
}

}  // namespace

bool find_outline(const cv::Mat& all_evidence,
                  const cv::Mat& all_certain,
                  const cv::Rect& region,
                  int closing_px,
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
  const cv::Mat element = disc(closing_px);
  cv::morphologyEx(s->positive, s->positive, cv::MORPH_CLOSE, element);
  const int count = cv::connectedComponents(s->positive, s->labels, 8, CV_32S);
  const std::vector<Piece> pieces = weigh_pieces(evidence, certain, s->labels, count);
  const auto main =
      std::max_element(pieces.begin() + 1, pieces.end(), [](const Piece& a, const Piece& b) {
        return a.evidence < b.evidence;
      });
  if (count < 2 || main->evidence < kPieceEvidenceMin || main->box().area() < kPieceAreaMin) {
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

void cut_at_edges(const cv::Mat& picture,
                  const cv::Mat& opinion,
                  const cv::Mat& certain,
                  int reach_px,
                  cv::Mat* outline) {
  POLHODE_ASSERT(picture.size() == outline->size(), outline->total());
  cv::Rect box = cv::boundingRect(*outline);
  if (box.empty()) {
    return;
  }
  const int margin = std::max(4, std::max(box.width, box.height) / 8);
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect(0, 0, picture.cols, picture.rows);
  cv::Mat part = (*outline)(box);
  const cv::Mat sure = certain.empty() ? cv::Mat() : certain(box);
  if (!sure.empty()) {
    cv::bitwise_or(part, sure, part);
  }
  cv::Mat nodes;
  const int count = number_band(part, reach_px, &nodes);
  if (count == 0) {
    return;  // it fills the picture, and a cut through nothing is an error
  }
  Graph graph(static_cast<unsigned>(count), static_cast<unsigned>(4 * count));
  add_places(opinion(box), sure, part, nodes, &graph);
  tie_neighbours(picture(box), part, nodes, &graph);
  graph.maxFlow();
  for (int row = 0; row < box.height; ++row) {
    for (int column = 0; column < box.width; ++column) {
      const int node = nodes.at<int>(row, column);
      if (node >= 0) {
        part.at<std::uint8_t>(row, column) = graph.inSourceSegment(node) ? 255 : 0;
      }
    }
  }
}

}  // namespace polhode
