#include "mask/outline.hpp"

#include <algorithm>
#include <cmath>
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

/// Gaps of up to twice this are closed: the spacing of a body's texture.
int closing_radius(const cv::Size& size) { return std::max(2, size.width / 160); }

struct Piece {
  int label = 0;
  double evidence = 0.0;
  cv::Rect box;
};

/// Sum of positive evidence by piece.
std::vector<Piece> weigh_pieces(const cv::Mat& evidence,
                                const cv::Mat& certain,
                                int count,
                                const OutlineScratch& s) {
  std::vector<Piece> pieces(static_cast<std::size_t>(count));
  for (int row = 0; row < evidence.rows; ++row) {
    const auto* says = evidence.ptr<float>(row);
    const auto* label = s.labels.ptr<int>(row);
    const std::uint8_t* sure = certain.empty() ? nullptr : certain.ptr<std::uint8_t>(row);
    for (int column = 0; column < evidence.cols; ++column) {
      const float weight = sure != nullptr && sure[column] != 0 ? kCertainEvidence : says[column];
      pieces[static_cast<std::size_t>(label[column])].evidence +=
          static_cast<double>(std::max(0.0F, weight));
    }
  }
  for (int i = 0; i < count; ++i) {
    Piece& piece = pieces[static_cast<std::size_t>(i)];
    piece.label = i;
    piece.box = cv::Rect(s.stats.at<int>(i, cv::CC_STAT_LEFT),
                         s.stats.at<int>(i, cv::CC_STAT_TOP),
                         s.stats.at<int>(i, cv::CC_STAT_WIDTH),
                         s.stats.at<int>(i, cv::CC_STAT_HEIGHT));
  }
  return pieces;
}

/// A fifth of the evidence of the main piece, and nearer to it than a third of its size.
bool belongs(const Piece& piece, const Piece& main) {
  const int reach = std::max(main.box.width, main.box.height) / 3;
  const cv::Rect grown(main.box.x - reach,
                       main.box.y - reach,
                       main.box.width + 2 * reach,
                       main.box.height + 2 * reach);
  return piece.label == main.label ||
         (piece.evidence > 0.05 * main.evidence && (grown & piece.box).area() > 0);
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
  double squares = 1.0;
  for (int row = 0; row + 1 < gray.rows; ++row) {
    for (int column = 0; column + 1 < gray.cols; ++column) {
      const int p = gray.at<std::uint8_t>(row, column);
      squares += std::pow(p - gray.at<std::uint8_t>(row, column + 1), 2.0);
      squares += std::pow(p - gray.at<std::uint8_t>(row + 1, column), 2.0);
    }
  }
  return static_cast<double>(gray.total()) / squares;
}

using Graph = cv::detail::GCGraph<float>;

/// A node for each pixel of the box, with what speaks for or against target there.
void add_places(const cv::Mat& opinion,
                const cv::Mat& certain,
                const cv::Mat& outline,
                Graph* graph) {
  constexpr double kCertain = 1000.0;
  for (int row = 0; row < opinion.rows; ++row) {
    for (int column = 0; column < opinion.cols; ++column) {
      const bool rim =
          row == 0 || column == 0 || row + 1 == opinion.rows || column + 1 == opinion.cols;
      auto price = static_cast<double>(opinion.at<float>(row, column));
      if (!certain.empty() && certain.at<std::uint8_t>(row, column) != 0) {
        price = kCertain;
      } else if (rim && outline.at<std::uint8_t>(row, column) == 0) {
        price = -kCertain;
      }
      graph->addTermWeights(graph->addVtx(),
                            static_cast<float>(std::max(price, 0.0)),
                            static_cast<float>(std::max(-price, 0.0)));
    }
  }
}

/// A cut between neighbours costs less, the larger the step between them.
void tie_neighbours(const cv::Mat& gray, Graph* graph) {
  constexpr double kEven = 6.0;  // price of cutting an even place
  const double falloff = step_falloff(gray);
  for (int row = 0; row < gray.rows; ++row) {
    for (int column = 0; column < gray.cols; ++column) {
      const int node = row * gray.cols + column;
      const int p = gray.at<std::uint8_t>(row, column);
      const auto tie = [&](int other, int level) {
        const auto weight =
            static_cast<float>(kEven * std::exp(-falloff * (p - level) * (p - level)));
        graph->addEdges(node, other, weight, weight);
      };
      if (column > 0) {
        tie(node - 1, gray.at<std::uint8_t>(row, column - 1));
      }
      if (row > 0) {
        tie(node - gray.cols, gray.at<std::uint8_t>(row - 1, column));
      }
    }
  }
}

}  // namespace

bool find_outline(const cv::Mat& all_evidence,
                  const cv::Mat& all_certain,
                  const cv::Rect& region,
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
  cv::threshold(
      evidence, s->closed, static_cast<double>(kTargetEvidence), 255.0, cv::THRESH_BINARY);
  s->closed.convertTo(s->positive, CV_8UC1);
  cv::medianBlur(s->positive, s->positive, 3);  // single pixels are noise
  if (!certain.empty()) {
    cv::bitwise_or(s->positive, certain, s->positive);
  }
  const cv::Mat element = disc(closing_radius(all_evidence.size()));
  cv::morphologyEx(s->positive, s->positive, cv::MORPH_CLOSE, element);
  const int count =
      cv::connectedComponentsWithStats(s->positive, s->labels, s->stats, s->centroids, 8, CV_32S);
  std::vector<Piece> pieces = weigh_pieces(evidence, certain, count, *s);
  const auto main =
      std::max_element(pieces.begin() + 1, pieces.end(), [](const Piece& a, const Piece& b) {
        return a.evidence < b.evidence;
      });
  if (count < 2 || main->evidence < kPieceEvidenceMin || main->box.area() < kPieceAreaMin) {
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
                  cv::Mat* outline) {
  POLHODE_ASSERT(picture.size() == outline->size(), outline->total());
  cv::Rect box = cv::boundingRect(*outline);
  if (box.empty()) {
    return;
  }
  const int margin = std::max(4, std::max(box.width, box.height) / 8);
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect(0, 0, picture.cols, picture.rows);
  Graph graph(static_cast<unsigned>(box.area()), static_cast<unsigned>(4 * box.area()));
  add_places(opinion(box), certain.empty() ? cv::Mat() : certain(box), (*outline)(box), &graph);
  tie_neighbours(picture(box), &graph);
  graph.maxFlow();
  outline->setTo(0);
  for (int row = 0; row < box.height; ++row) {
    for (int column = 0; column < box.width; ++column) {
      if (graph.inSourceSegment(row * box.width + column)) {
        outline->at<std::uint8_t>(row + box.y, column + box.x) = 255;
      }
    }
  }
}

}  // namespace polhode
