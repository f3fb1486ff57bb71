#include "mask/edge_cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>
#include <vector>

#include "base/assert.hpp"
#include "mask/grown.hpp"
#include "mask/shrink.hpp"

namespace polhode {
namespace {

// Whole numbers, and coarse ones: paths of the flow fill up together, in less than half of the time
// that real numbers take.
using Graph = cv::detail::GCGraph<int>;

constexpr double kPricePerOpinion = 2.0;
constexpr int kEven = 12;  // price of cutting an even place
constexpr int kCertain = 1000;

/// What is cut, by cells; all but opinions of one size.
struct Cells {
  int side_px;       ///< of the picture's pixels
  int per_opinion;   ///< cells per cell of `weight` and `certain`, along a side
  cv::Mat weight;    ///< CV_32FC1
  cv::Mat certain;   ///< CV_8UC1, may be empty
  cv::Mat outline;   ///< CV_8UC1
  cv::Mat left, up;  ///< CV_8UC1: step to the neighbour, levels
};

/// The largest of each cell.
cv::Mat largest(const cv::Mat& pixels, int cell_px) {
  if (cell_px == 1) {
    return pixels;
  }
  cv::Mat grown;
  cv::dilate(pixels, grown, cv::Mat::ones(cell_px, cell_px, CV_8UC1), cv::Point(0, 0));
  cv::Mat cells;
  cv::resize(grown, cells, pixels.size() / cell_px, 0.0, 0.0, cv::INTER_NEAREST);
  return cells;
}

/// Steps of a cell are the largest in it, as the near cut finds the place in the cell. Of halved
/// pictures edges between two cells are half as high, and outlines of rooms overlap by 0.01 less.
/// @param outline of the edges' box, as far as whole cells fill it.
Cells to_cells(const PictureEdges& edges,
               const CutOpinion& opinion,
               const cv::Mat& outline,
               int cell_px) {
  const cv::Rect asked = coarser(edges.box, opinion.cell_px);
  const cv::Rect part(cv::Point(), outline.size());
  Cells cells{.side_px = cell_px,
              .per_opinion = opinion.cell_px / cell_px,
              .weight = opinion.weight(asked),
              .certain = opinion.certain.empty() ? cv::Mat() : opinion.certain(asked),
              .outline = {},
              .left = largest(edges.left(part), cell_px),
              .up = largest(edges.up(part), cell_px)};
  cover_by_half(outline, cells.left.size(), &cells.outline);
  if (!cells.certain.empty()) {
    cv::Mat certain(cells.outline.size(), CV_8UC1);
    fill_from_cells(cells.certain, cells.per_opinion, {cv::Point(), certain.size()}, &certain);
    cv::bitwise_or(cells.outline, certain, cells.outline);
  }
  return cells;
}

/// Price of calling a cell background; negative: of calling it target. What is at the box's rim
/// and outside of the outline is background.
int price_at(const Cells& cells, cv::Point at) {
  const cv::Point asked = at / cells.per_opinion;
  if (!cells.certain.empty() && cells.certain.at<std::uint8_t>(asked) != 0) {
    return kCertain;
  }
  const cv::Mat& outline = cells.outline;
  const bool rim = at.y == 0 || at.x == 0 || at.y + 1 == outline.rows || at.x + 1 == outline.cols;
  if (rim && outline.at<std::uint8_t>(at) == 0) {
    return -kCertain;
  }
  // All of a cell's pixels speak, and a cut runs along one side of it.
  return cvRound(kPricePerOpinion * cells.side_px *
                 static_cast<double>(cells.weight.at<float>(asked)));
}

void add_price(int node, int price, Graph* graph) {
  graph->addTermWeights(node, std::max(price, 0), std::max(-price, 0));
}

/// Cells near the outline, where it may be moved to.
struct Band {
  std::vector<cv::Point>
      cells;      ///< row by row; their place in this list is their node in the graph
  cv::Mat nodes;  ///< CV_32SC1: of all cells, -1 outside of the band
};

Band band_about(const cv::Mat& outline, int reach) {
  const cv::Mat square = cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8UC1);
  cv::Mat grown;
  cv::Mat shrunk;
  cv::dilate(outline, grown, square);
  cv::erode(outline, shrunk, square);
  cv::compare(grown, shrunk, grown, cv::CMP_NE);
  Band band;
  cv::findNonZero(grown, band.cells);
  band.nodes.create(outline.size(), CV_32SC1);
  band.nodes.setTo(-1);
  int node = 0;
  for (const cv::Point& at : band.cells) {
    band.nodes.at<int>(at) = node++;
  }
  return band;
}

/// Price of a cut between neighbours by the step between them: the less, the larger it is. One of
/// the mean square size costs 1/e of an even place.
std::array<int, 256> tie_prices(double mean_square_step) {
  std::array<int, 256> prices{};
  for (std::size_t step = 0; step < prices.size(); ++step) {
    const auto levels = static_cast<double>(step);
    prices[step] = cvRound(kEven * std::exp(-levels * levels / mean_square_step));
  }
  return prices;
}

/// What lies beyond the band stays as it is: a cut from it is a price of the cell beside it.
void tie_neighbours(const Cells& cells, const Band& band, double mean_square_step, Graph* graph) {
  const std::array<int, 256> prices = tie_prices(mean_square_step);
  int node = 0;
  const auto tie = [&](const cv::Point& neighbour, std::uint8_t step, bool is_before) {
    const int price = prices[step];
    const int other = band.nodes.at<int>(neighbour);
    if (other < 0) {
      const bool target = cells.outline.at<std::uint8_t>(neighbour) != 0;
      add_price(node, target ? price : -price, graph);
    } else if (is_before && price > 0) {  // once for two of the band
      graph->addEdges(node, other, price, price);
    }
  };
  for (const cv::Point& at : band.cells) {
    const cv::Point right(at.x + 1, at.y);
    const cv::Point below(at.x, at.y + 1);
    if (at.x > 0) {
      tie({at.x - 1, at.y}, cells.left.at<std::uint8_t>(at), true);
    }
    if (at.y > 0) {
      tie({at.x, at.y - 1}, cells.up.at<std::uint8_t>(at), true);
    }
    if (right.x < band.nodes.cols) {
      tie(right, cells.left.at<std::uint8_t>(right), false);
    }
    if (below.y < band.nodes.rows) {
      tie(below, cells.up.at<std::uint8_t>(below), false);
    }
    ++node;
  }
}

/// @return false where nothing may be moved: a cut through nothing is an error.
bool cut(int reach, double mean_square_step, Cells* cells) {
  const Band band = band_about(cells->outline, reach);
  const std::size_t count = band.cells.size();
  if (count == 0) {
    return false;
  }
  Graph graph(static_cast<unsigned>(count), static_cast<unsigned>(4 * count));
  for (const cv::Point& at : band.cells) {
    add_price(graph.addVtx(), price_at(*cells, at), &graph);
  }
  tie_neighbours(*cells, band, mean_square_step, &graph);
  graph.maxFlow();
  int node = 0;
  for (const cv::Point& at : band.cells) {
    cells->outline.at<std::uint8_t>(at) = graph.inSourceSegment(node++) ? 255 : 0;
  }
  return true;
}

}  // namespace

void measure_edges(const cv::Mat& picture, const cv::Rect& box, PictureEdges* edges) {
  constexpr int kCell_px = 2;
  const cv::Rect whole(cv::Point(), picture.size());
  const cv::Rect cells = coarser(box, kCell_px);
  edges->box = cv::Rect(cells.tl() * kCell_px, cells.size() * kCell_px) & whole;
  const cv::Mat part = picture(edges->box);
  double squares = 1.0;
  const auto along = [&](const cv::Point& shift, cv::Mat* steps) {
    steps->create(part.size(), CV_8UC1);
    steps->setTo(0);
    const cv::Rect here(shift, cv::Point(part.cols, part.rows));
    cv::absdiff(part(here), part(here - shift), (*steps)(here));
    squares += cv::norm(*steps, cv::NORM_L2SQR);
  };
  along({1, 0}, &edges->left);
  along({0, 1}, &edges->up);
  edges->mean_square_step = squares / std::max(1.0, static_cast<double>(part.total()));
}

void cut_at_edges(const PictureEdges& edges,
                  const CutOpinion& opinion,
                  const CutReach& reach,
                  cv::Mat* outline) {
  POLHODE_ASSERT(opinion.cell_px == 1 || opinion.cell_px == 2, opinion.cell_px);
  POLHODE_ASSERT(reach.cell_px == 1 || reach.cell_px == opinion.cell_px, reach.cell_px);
  const cv::Size asked = coarser({cv::Point(), outline->size()}, opinion.cell_px).size();
  POLHODE_ASSERT(opinion.weight.size() == asked, opinion.weight.total());
  POLHODE_ASSERT(opinion.certain.empty() || opinion.certain.size() == asked,
                 opinion.certain.total());
  const cv::Rect whole_cells(edges.box.tl(), edges.box.size() / reach.cell_px * reach.cell_px);
  if (whole_cells.empty()) {
    return;
  }
  cv::Mat part = (*outline)(whole_cells);
  Cells cells = to_cells(edges, opinion, part, reach.cell_px);
  if (cut(reach.px / reach.cell_px, edges.mean_square_step, &cells)) {
    cv::resize(cells.outline, part, part.size(), 0.0, 0.0, cv::INTER_LINEAR);
    cv::threshold(part, part, 127.0, 255.0, cv::THRESH_BINARY);
  }
}

}  // namespace polhode
