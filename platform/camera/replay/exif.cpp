#include "camera/replay/exif.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace polhode::platform {
namespace {

/// Numbers of either byte order, zero beyond the end. EXIF 2.32, 4.6: a TIFF file in a segment.
class Tiff {
 public:
  explicit Tiff(Bytes bytes)
      : bytes_(bytes), little_(bytes.size() > 1 && bytes[0] == 'I' && bytes[1] == 'I') {}

  [[nodiscard]] std::size_t number(std::size_t at, std::size_t bytes) const {
    std::size_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      const std::size_t from = at + (little_ ? bytes - 1 - i : i);
      value = value << 8U | (from < bytes_.size() ? bytes_[from] : 0U);
    }
    return value;
  }

 private:
  Bytes bytes_;
  bool little_;
};

/// Of the first folder.
int orientation_of(const Tiff& tiff) {
  constexpr std::size_t kEntryBytes = 12;
  constexpr std::size_t kEntriesMax = 512;  // cameras write some ten
  constexpr std::size_t kOrientation = 0x0112;
  constexpr std::size_t kShort = 3;
  const std::size_t folder = tiff.number(4, 4);
  const std::size_t entries = std::min(tiff.number(folder, 2), kEntriesMax);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t at = folder + 2 + i * kEntryBytes;
    if (tiff.number(at, 2) == kOrientation && tiff.number(at + 2, 2) == kShort) {
      const auto value = static_cast<int>(tiff.number(at + 8, 2));
      return value >= 1 && value <= 8 ? value : 1;
    }
  }
  return 1;
}

}  // namespace

int exif_orientation(Bytes jpeg) {
  constexpr std::string_view kMark("Exif\0\0", 6);
  std::size_t at = 2;  // after the marker that begins the image
  while (at + 4 <= jpeg.size() && jpeg[at] == 0xFF) {
    const unsigned marker = jpeg[at + 1];
    const std::size_t bytes = std::size_t{jpeg[at + 2]} << 8U | jpeg[at + 3];
    const std::size_t end = at + 2 + bytes;
    if (marker == 0xDA || bytes < 2 || end > jpeg.size()) {  // the image itself, or damage
      return 1;
    }
    const Bytes content = jpeg.subspan(at + 4, bytes - 2);
    if (marker == 0xE1 && content.size() > kMark.size() &&
        std::equal(kMark.begin(), kMark.end(), content.begin())) {
      return orientation_of(Tiff(content.subspan(kMark.size())));
    }
    at = end;
  }
  return 1;
}

}  // namespace polhode::platform
