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

// Costs as coarse whole numbers: augmenting paths saturate together, in 0.45 of the time of real
// numbers (decision 0011).
using Graph = cv::detail::GCGraph<int>;

// Cost of a boundary along a pixel's side in an even place (decision 0007): far over a unary cost.
constexpr double kEvenCost = 6.0;
// Whole numbers per unit of cost. Chosen; larger rounds less and takes longer.
constexpr double kScale = 2.0;
// Cost of a seed: above the sum of a cell's four boundaries and its unary cost.
constexpr int kHardCost = 1000;

/// Input of a cut, by cells; all but the unary costs have one size.
struct Cells {
  int side_px;       ///< of the image's pixels
  int per_unary;     ///< cells per cell of `unary` and `seeds`, along a side
  cv::Mat unary;     ///< CV_32FC1
  cv::Mat seeds;     ///< CV_8UC1, may be empty
  cv::Mat outline;   ///< CV_8UC1
  cv::Mat left, up;  ///< CV_8UC1: step to the neighbour, levels
};

/// The largest level of each cell.
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

/// A cell's step is the largest in it, as the cut by pixels finds the place in the cell. In halved
/// images edges between two cells are half as high, and outlines in rooms overlap by 0.01 less
/// (decision 0011).
/// @param outline of the edges' box, as far as whole cells fill it.
Cells to_cells(const ImageEdges& edges,
               const UnaryCost& unary_cost,
               const cv::Mat& outline,
               int cell_px) {
  const cv::Rect box = coarser(edges.box, unary_cost.cell_px);
  const cv::Rect part(cv::Point(), outline.size());
  Cells cells{.side_px = cell_px,
              .per_unary = unary_cost.cell_px / cell_px,
              .unary = unary_cost.value(box),
              .seeds = unary_cost.seeds.empty() ? cv::Mat() : unary_cost.seeds(box),
              .outline = {},
              .left = largest(edges.left(part), cell_px),
              .up = largest(edges.up(part), cell_px)};
  cover_by_half(outline, cells.left.size(), &cells.outline);
  if (!cells.seeds.empty()) {
    cv::Mat seeds(cells.outline.size(), CV_8UC1);
    fill_from_cells(cells.seeds, cells.per_unary, {cv::Point(), seeds.size()}, &seeds);
    cv::bitwise_or(cells.outline, seeds, cells.outline);
  }
  return cells;
}

/// Cost of calling a cell background; negative: of calling it target. At the border of the box the
/// neighbours outside keep the outline's class.
int unary_at(const Cells& cells, cv::Point at) {
  const cv::Point in_unary = at / cells.per_unary;
  if (!cells.seeds.empty() && cells.seeds.at<std::uint8_t>(in_unary) != 0) {
    return kHardCost;
  }
  const cv::Mat& outline = cells.outline;
  const bool at_border =
      at.y == 0 || at.x == 0 || at.y + 1 == outline.rows || at.x + 1 == outline.cols;
  if (at_border && outline.at<std::uint8_t>(at) == 0) {
    return -kHardCost;
  }
  // A cell has the square of its side in pixels, and a boundary runs along one side of it.
  return cvRound(kScale * cells.side_px * static_cast<double>(cells.unary.at<float>(in_unary)));
}

void add_unary(int node, int cost, Graph* graph) {
  graph->addTermWeights(node, std::max(cost, 0), std::max(-cost, 0));
}

/// Cells near the outline, in which it may be moved.
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

/// Cost of a boundary between neighbours: it falls with the step between them. A step of the mean
/// square costs 1/e of an even place.
std::array<int, 256> smoothness_costs(double mean_square_step) {
  std::array<int, 256> costs{};
  for (std::size_t step = 0; step < costs.size(); ++step) {
    const auto levels = static_cast<double>(step);
    costs[step] = cvRound(kScale * kEvenCost * std::exp(-levels * levels / mean_square_step));
  }
  return costs;
}

/// Adds the edges between neighbours. Cells beyond the band keep their class: a boundary to one is
/// a unary cost of the cell beside it.
/// @return false: there is none.
bool add_smoothness(const Cells& cells, const Band& band, double mean_square_step, Graph* graph) {
  const std::array<int, 256> costs = smoothness_costs(mean_square_step);
  int node = 0;
  bool any = false;
  const auto connect = [&](const cv::Point& neighbour, std::uint8_t step, bool is_before) {
    const int cost = costs[step];
    const int other = band.nodes.at<int>(neighbour);
    if (other < 0) {
      const bool target = cells.outline.at<std::uint8_t>(neighbour) != 0;
      add_unary(node, target ? cost : -cost, graph);
    } else if (is_before && cost > 0) {  // once for two of the band
      graph->addEdges(node, other, cost, cost);
      any = true;
    }
  };
  for (const cv::Point& at : band.cells) {
    const cv::Point right(at.x + 1, at.y);
    const cv::Point below(at.x, at.y + 1);
    if (at.x > 0) {
      connect({at.x - 1, at.y}, cells.left.at<std::uint8_t>(at), true);
    }
    if (at.y > 0) {
      connect({at.x, at.y - 1}, cells.up.at<std::uint8_t>(at), true);
    }
    if (right.x < band.nodes.cols) {
      connect(right, cells.left.at<std::uint8_t>(right), false);
    }
    if (below.y < band.nodes.rows) {
      connect(below, cells.up.at<std::uint8_t>(below), false);
    }
    ++node;
  }
  return any;
}

/// @return false where no cell may change: OpenCV takes no graph without edges. In a pattern of
/// single pixels all steps may be free to cut.
bool graph_cut(int reach, double mean_square_step, Cells* cells) {
  const Band band = band_about(cells->outline, reach);
  const std::size_t count = band.cells.size();
  Graph graph(static_cast<unsigned>(count), static_cast<unsigned>(4 * count));
  for (const cv::Point& at : band.cells) {
    add_unary(graph.addVtx(), unary_at(*cells, at), &graph);
  }
  if (!add_smoothness(*cells, band, mean_square_step, &graph)) {
    return false;
  }
  graph.maxFlow();
  int node = 0;
  for (const cv::Point& at : band.cells) {
    cells->outline.at<std::uint8_t>(at) = graph.inSourceSegment(node++) ? 255 : 0;
  }
  return true;
}

}  // namespace

void measure_edges(const cv::Mat& image, const cv::Rect& box, ImageEdges* edges) {
  constexpr int kCell_px = 2;  // the larger of the two sizes that cut_at_edges takes
  const cv::Rect whole(cv::Point(), image.size());
  const cv::Rect cells = coarser(box, kCell_px);
  edges->box = cv::Rect(cells.tl() * kCell_px, cells.size() * kCell_px) & whole;
  const cv::Mat part = image(edges->box);
  double squares = 1.0;  // so that an even image divides by no zero
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

void cut_at_edges(const ImageEdges& edges,
                  const UnaryCost& unary_cost,
                  const CutReach& reach,
                  cv::Mat* outline) {
  POLHODE_ASSERT(unary_cost.cell_px == 1 || unary_cost.cell_px == 2, unary_cost.cell_px);
  POLHODE_ASSERT(reach.cell_px == 1 || reach.cell_px == unary_cost.cell_px, reach.cell_px);
  const cv::Size size = coarser({cv::Point(), outline->size()}, unary_cost.cell_px).size();
  POLHODE_ASSERT(unary_cost.value.size() == size, unary_cost.value.total());
  POLHODE_ASSERT(unary_cost.seeds.empty() || unary_cost.seeds.size() == size,
                 unary_cost.seeds.total());
  const cv::Rect whole_cells(edges.box.tl(), edges.box.size() / reach.cell_px * reach.cell_px);
  if (whole_cells.empty()) {
    return;
  }
  cv::Mat part = (*outline)(whole_cells);
  Cells cells = to_cells(edges, unary_cost, part, reach.cell_px);
  if (graph_cut(reach.px / reach.cell_px, edges.mean_square_step, &cells)) {
    cv::resize(cells.outline, part, part.size(), 0.0, 0.0, cv::INTER_LINEAR);
    constexpr double kHalf = 127.0;  // as in cover_by_half
    cv::threshold(part, part, kHalf, 255.0, cv::THRESH_BINARY);
  }
}

}  // namespace polhode
