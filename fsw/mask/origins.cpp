#include "mask/origins.hpp"

#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "base/wide.hpp"
#include "mask/grown.hpp"

namespace polhode {
namespace {

constexpr int kBits = cv::INTER_BITS;
constexpr int kUnits = cv::INTER_TAB_SIZE;  // a pixel
constexpr int kBeyond_px = 8;               // the picture goes on as its rim

/// Whole units from the start of what is beyond the picture. No number counts as there.
int units_of(float at_px, float most_px) {
  const float raised = at_px > -kBeyond_px ? at_px : -kBeyond_px;
  const float kept = raised < most_px ? raised : most_px;
  return static_cast<int>((kept + kBeyond_px) * kUnits + 0.5F);
}

/// Writes origins in rows of a region.
class Writer {
 public:
  Writer(const cv::Size& size, const cv::Size& before, Origins* origins)
      : most_u_px_(static_cast<float>(before.width + kBeyond_px)),
        most_v_px_(static_cast<float>(before.height + kBeyond_px)),
        origins_(origins) {
    origins->pixel.create(size, CV_16SC2);
    origins->fraction.create(size, CV_16UC1);
  }

  void start_row(int row) {
    pixel_ = origins_->pixel.ptr<std::int16_t>(row);
    fraction_ = origins_->fraction.ptr<std::uint16_t>(row);
  }

  void put(int column, float u_px, float v_px) const {
    const int u = units_of(u_px, most_u_px_);
    const int v = units_of(v_px, most_v_px_);
    pixel_[2 * column] = static_cast<std::int16_t>((u >> kBits) - kBeyond_px);
    pixel_[2 * column + 1] = static_cast<std::int16_t>((v >> kBits) - kBeyond_px);
    fraction_[column] = static_cast<std::uint16_t>((v & (kUnits - 1)) << kBits | (u & (kUnits - 1)));
  }

 private:
  float most_u_px_, most_v_px_;
  Origins* origins_;
  std::int16_t* pixel_ = nullptr;
  std::uint16_t* fraction_ = nullptr;
};

}  // namespace

void trace_plane(const cv::Matx33d& motion, const cv::Rect& region, const cv::Size& before_size, Origins* origins) {
  const cv::Matx33d back = motion.inv();
  Writer writer(region.size(), before_size, origins);
  const auto along_u = static_cast<float>(back(0, 0));
  const auto along_v = static_cast<float>(back(1, 0));
  const auto along_w = static_cast<float>(back(2, 0));
  widely([&] {
    for (int row = 0; row < region.height; ++row) {
      writer.start_row(row);
      const cv::Vec3d start = back * cv::Vec3d(region.x, region.y + row, 1.0);
      const cv::Vec3f first = start;
      for (int column = 0; column < region.width; ++column) {
        const auto x = static_cast<float>(column);
        const float w = 1.0F / (first[2] + along_w * x);
        writer.put(column, (first[0] + along_u * x) * w, (first[1] + along_v * x) * w);
      }
    }
  });
}

void trace_flow(const cv::Mat& flow,
                int cell_px,
                const cv::Rect& region,
                int step,
                const cv::Size& before_size,
                Origins* origins) {
  const cv::Rect cells = coarser(region, cell_px);
  cv::resize(flow(cells), origins->flow, cells.size() * (cell_px / step), 0.0, 0.0, cv::INTER_LINEAR);
  const cv::Rect part = coarser(region, step);
  Writer writer(part.size(), before_size, origins);
  const float scale = 1.0F / static_cast<float>(step);
  widely([&] {
    for (int row = 0; row < part.height; ++row) {
      writer.start_row(row);
      const auto* come = origins->flow.ptr<float>(row);
      const auto v = static_cast<float>(part.y + row);
      for (int column = 0; column < part.width; ++column) {
        const auto u = static_cast<float>(part.x + column);
        writer.put(column, u - scale * come[2 * column], v - scale * come[2 * column + 1]);
      }
    }
  });
}

void look_up(const cv::Mat& before, const Origins& origins, cv::Mat* out) {
  cv::remap(before, *out, origins.pixel, origins.fraction, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
}

}  // namespace polhode
