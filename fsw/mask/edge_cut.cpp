#include "mask/edge_cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>
#include <vector>

#include "base/assert.hpp"
#include "mask/grown.hpp"

namespace polhode {
namespace {

// Whole numbers, and coarse ones: paths of the flow fill up together, in less than half of the time that real numbers take.
using Graph = cv::detail::GCGraph<int>;

constexpr double kPricePerOpinion = 2.0;
constexpr int kEven = 12;  // price of cutting an even place
constexpr int kCertain = 1000;

/// What is cut, by cells; all of one size.
struct Cells {
  cv::Mat opinion;  ///< CV_32FC1: a cell's sum over its side
  cv::Mat certain;  ///< CV_8UC1, may be empty
  cv::Mat outline;  ///< CV_8UC1
  cv::Mat left, up;  ///< CV_8UC1: step to the neighbour, levels
  double mean_square_step = 1.0;  ///< of the picture's pixels, both directions together
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

/// Steps between neighbours: a cell's are the largest in it, as the near cut finds the place in the cell. Of halved pictures edges
/// between two cells are half as high, and outlines of rooms overlap by 0.01 less.
void measure_steps(const cv::Mat& picture, int cell_px, Cells* cells) {
  const cv::Rect whole(cv::Point(), picture.size());
  cv::Mat steps(picture.size(), CV_8UC1);
  double squares = 1.0;
  const auto along = [&](const cv::Point& shift) {
    steps.setTo(0);
    const cv::Rect here(shift, whole.br());
    cv::absdiff(picture(here), picture(here - shift), steps(here));
    squares += cv::norm(steps, cv::NORM_L2SQR);
    return largest(steps, cell_px);
  };
  cells->left = along({1, 0}).clone();
  cells->up = along({0, 1});
  cells->mean_square_step = squares / static_cast<double>(whole.area());
}

void halve(const cv::Mat& pixels, cv::Mat* cells) {
  cv::resize(pixels, *cells, pixels.size() / 2, 0.0, 0.0, cv::INTER_AREA);
}

Cells to_cells(const cv::Mat& picture,
               const cv::Mat& opinion,
               const cv::Mat& certain,
               const cv::Mat& outline,
               int cell_px) {
  Cells cells{.opinion = opinion, .certain = certain, .outline = outline, .left = {}, .up = {}};
  measure_steps(picture, cell_px, &cells);
  if (cell_px == 2) {
    halve(opinion, &cells.opinion);
    cells.opinion *= 2.0;  // four pixels speak, and a cut runs along two
    halve(outline, &cells.outline);
    cv::threshold(cells.outline, cells.outline, 127.0, 255.0, cv::THRESH_BINARY);
    cells.certain = certain.empty() ? certain : largest(certain, cell_px);
  }
  if (!cells.certain.empty()) {
    cv::bitwise_or(cells.outline, cells.certain, cells.outline);
  }
  return cells;
}

/// Price of calling a cell background; negative: of calling it target. What is at the box's rim
/// and outside of the outline is background.
int price_at(const Cells& cells, cv::Point at) {
  if (!cells.certain.empty() && cells.certain.at<std::uint8_t>(at) != 0) {
    return kCertain;
  }
  const cv::Mat& outline = cells.outline;
  const bool rim =
      at.y == 0 || at.x == 0 || at.y + 1 == outline.rows || at.x + 1 == outline.cols;
  return rim && outline.at<std::uint8_t>(at) == 0
             ? -kCertain
             : cvRound(kPricePerOpinion * static_cast<double>(cells.opinion.at<float>(at)));
}

void add_price(int node, int price, Graph* graph) {
  graph->addTermWeights(node, std::max(price, 0), std::max(-price, 0));
}

/// Cells near the outline, where it may be moved to.
struct Band {
  std::vector<cv::Point> cells;  ///< row by row; their place in this list is their node in the graph
  cv::Mat nodes;                 ///< CV_32SC1: of all cells, -1 outside of the band
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

/// Price of a cut between neighbours by the step between them: the less, the larger it is. One of the mean square size costs 1/e of
/// an even place.
std::array<int, 256> tie_prices(double mean_square_step) {
  std::array<int, 256> prices{};
  for (std::size_t step = 0; step < prices.size(); ++step) {
    const auto levels = static_cast<double>(step);
    prices[step] = cvRound(kEven * std::exp(-levels * levels / mean_square_step));
  }
  return prices;
}

/// What lies beyond the band stays as it is: a cut from it is a price of the cell beside it.
void tie_neighbours(const Cells& cells, const Band& band, Graph* graph) {
  const std::array<int, 256> prices = tie_prices(cells.mean_square_step);
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
bool cut(int reach, Cells* cells) {
  const Band band = band_about(cells->outline, reach);
  const std::size_t count = band.cells.size();
  if (count == 0) {
    return false;
  }
  Graph graph(static_cast<unsigned>(count), static_cast<unsigned>(4 * count));
  for (const cv::Point& at : band.cells) {
    add_price(graph.addVtx(), price_at(*cells, at), &graph);
  }
  tie_neighbours(*cells, band, &graph);
  graph.maxFlow();
  int node = 0;
  for (const cv::Point& at : band.cells) {
    cells->outline.at<std::uint8_t>(at) = graph.inSourceSegment(node++) ? 255 : 0;
  }
  return true;
}

}  // namespace

void cut_at_edges(const cv::Mat& picture,
                  const cv::Mat& opinion,
                  const cv::Mat& certain,
                  const CutReach& reach,
                  cv::Mat* outline) {
  POLHODE_ASSERT(picture.size() == outline->size(), outline->total());
  POLHODE_ASSERT(reach.cell_px == 1 || reach.cell_px == 2, reach.cell_px);
  cv::Rect box = cv::boundingRect(*outline);
  if (box.empty()) {
    return;
  }
  const int margin = std::max(4, std::max(box.width, box.height) / 8);
  box = grown(box, margin) & cv::Rect(0, 0, picture.cols, picture.rows);
  box.width -= box.width % reach.cell_px;
  box.height -= box.height % reach.cell_px;
  cv::Mat part = (*outline)(box);
  const cv::Mat sure = certain.empty() ? cv::Mat() : certain(box);
  Cells cells = to_cells(picture(box), opinion(box), sure, part, reach.cell_px);
  if (cut(reach.px / reach.cell_px, &cells) && reach.cell_px == 2) {
    cv::resize(cells.outline, part, part.size(), 0.0, 0.0, cv::INTER_LINEAR);
    cv::threshold(part, part, 127.0, 255.0, cv::THRESH_BINARY);
  }
}

}  // namespace polhode
