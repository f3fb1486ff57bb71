#include "mask/origins.hpp"

#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "base/assert.hpp"
#include "base/avx2_dispatch.hpp"
#include "mask/grown.hpp"

namespace polhode {
namespace {

/// The nearest pixel up to the last one. NaN counts as the first.
int nearest(float at_px, float last_px) {
  const float raised = at_px > 0.0F ? at_px : 0.0F;
  const float kept = raised < last_px ? raised : last_px;
  return static_cast<int>(kept + 0.5F);
}

/// Size of the earlier image.
struct Before {
  explicit Before(const cv::Size& size)
      : last_u_px(static_cast<float>(size.width - 1)),
        last_v_px(static_cast<float>(size.height - 1)),
        width(size.width) {}

  [[nodiscard]] std::int32_t index(float u_px, float v_px) const {
    return nearest(v_px, last_v_px) * width + nearest(u_px, last_u_px);
  }

  float last_u_px, last_v_px;
  int width;
};

/// Interpolates between the middles of the grid's cells.
void spread_flow(const cv::Mat& flow, int cell_px, const cv::Rect& region, int step, cv::Mat* out) {
  const cv::Rect cells = coarser(region, cell_px);
  cv::resize(flow(cells), *out, cells.size() * (cell_px / step), 0.0, 0.0, cv::INTER_LINEAR);
}

}  // namespace

void trace_plane(const cv::Matx33d& motion,
                 const cv::Rect& region,
                 const cv::Size& before_size,
                 Origins* origins) {
  const cv::Matx33d back = motion.inv();
  origins->index.create(region.size(), CV_32SC1);
  const auto along_u = static_cast<float>(back(0, 0));
  const auto along_v = static_cast<float>(back(1, 0));
  const auto along_w = static_cast<float>(back(2, 0));
  with_avx2([&] {
    const Before before(before_size);
    const int columns = region.width;  // a copy: written indices might alias the original
    for (int row = 0; row < region.height; ++row) {
      auto* index = origins->index.ptr<std::int32_t>(row);
      const cv::Vec3f first = back * cv::Vec3d(region.x, region.y + row, 1.0);
      const float first_u = first[0];
      const float first_v = first[1];
      const float first_w = first[2];
      for (int column = 0; column < columns; ++column) {
        const auto x = static_cast<float>(column);
        const float w = 1.0F / (first_w + along_w * x);
        index[column] = before.index((first_u + along_u * x) * w, (first_v + along_v * x) * w);
      }
    }
  });
}

void trace_flow(const cv::Mat& flow,
                int cell_px,
                const cv::Rect& region,
                const cv::Size& before_size,
                Origins* origins) {
  spread_flow(flow, cell_px, region, 1, &origins->flow);
  origins->index.create(region.size(), CV_32SC1);
  with_avx2([&] {
    const Before before(before_size);
    const int columns = region.width;  // as above
    const int left = region.x;
    for (int row = 0; row < region.height; ++row) {
      auto* index = origins->index.ptr<std::int32_t>(row);
      const auto* come = origins->flow.ptr<float>(row);
      const auto v = static_cast<float>(region.y + row);
      for (int column = 0; column < columns; ++column) {
        const auto u = static_cast<float>(left + column);
        index[column] = before.index(u - come[2 * column], v - come[2 * column + 1]);
      }
    }
  });
}

void look_up(const cv::Mat& before, const Origins& origins, cv::Mat* out) {
  POLHODE_ASSERT(before.isContinuous(), before.total());
  POLHODE_ASSERT(before.type() == CV_16UC1, before.type());
  out->create(origins.index.size(), CV_16UC1);
  const auto* from = before.ptr<std::uint16_t>();
  for (int row = 0; row < out->rows; ++row) {
    const auto* index = origins.index.ptr<std::int32_t>(row);
    auto* to = out->ptr<std::uint16_t>(row);
    for (int column = 0; column < out->cols; ++column) {
      to[column] = from[index[column]];
    }
  }
}

void carry(const cv::Mat& flow,
           const CarriedRegion& to,
           const cv::Mat& before,
           cv::Mat* from,
           cv::Mat* out) {
  const auto& [region, step, cell_px] = to;
  spread_flow(flow, cell_px, region, step, from);
  const cv::Rect part = coarser(region, step);
  const float scale = 1.0F / static_cast<float>(step);
  for (int row = 0; row < part.height; ++row) {
    auto* at = from->ptr<cv::Point2f>(row);
    for (int column = 0; column < part.width; ++column) {
      at[column] = cv::Point2f(cv::Point(column, row) + part.tl()) - scale * at[column];
    }
  }
  cv::remap(
      before, *out, (*from)(cv::Rect({}, part.size())), {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
}

}  // namespace polhode
