#include "mask/target_levels.hpp"

namespace polhode {

LevelCounts target_levels(const cv::Mat& gray, const MaskOptions& options, const TargetMask& mask) {
  LevelCounts counts{};
  const int dark = static_cast<int>(options.dark_level * 255.0);
  for (int row = mask.region_px.y; row < mask.region_px.br().y; ++row) {
    const std::uint8_t* pixel = gray.ptr<std::uint8_t>(row);
    const std::uint8_t* cell = mask.cells.ptr<std::uint8_t>(row / TargetMask::kCell_px);
    for (int column = mask.region_px.x; column < mask.region_px.br().x; ++column) {
      if (cell[column / TargetMask::kCell_px] != 0 && pixel[column] > dark) {
        ++counts[pixel[column]];
      }
    }
  }
  return counts;
}

}  // namespace polhode
