#include "camera/replay/exif.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "base/rng.hpp"
#include "encode.hpp"

namespace polhode::platform::exif_test {
namespace {

/// A segment as cameras write it: one entry before, then the orientation.
File exif(bool little, std::uint16_t orientation) {
  File tiff = little ? File{'I', 'I', 42, 0, 8, 0, 0, 0} : File{'M', 'M', 0, 42, 0, 0, 0, 8};
  const auto put = [&](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
      const int shift = 8 * (little ? i : bytes - 1 - i);
      tiff.push_back(static_cast<std::uint8_t>(value >> shift));
    }
  };
  put(2, 2);
  for (const auto& [tag, value] :
       {std::pair(0x0106U, 2U), std::pair(0x0112U, unsigned{orientation})}) {
    put(tag, 2);
    put(3, 2);
    put(1, 4);
    put(value, 2);
    put(0, 2);
  }
  put(0, 4);
  File segment{0xFF, 0xE1, 0, static_cast<std::uint8_t>(8 + tiff.size())};
  for (const char c : std::string_view("Exif\0\0", 6)) {
    segment.push_back(static_cast<std::uint8_t>(c));
  }
  for (const std::uint8_t byte : tiff) {
    segment.push_back(byte);
  }
  return segment;
}

File with(const File& segment) {
  File jpeg = encode_jpeg(8, 8, File(64, 100));
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

TEST(Exif, TellsTheOrientationInEitherByteOrder) {
  for (std::uint16_t orientation = 1; orientation <= 8; ++orientation) {
    EXPECT_EQ(exif_orientation(with(exif(true, orientation))), orientation);
    EXPECT_EQ(exif_orientation(with(exif(false, orientation))), orientation);
  }
}

TEST(Exif, IsOneWhereNothingElseIsSaid) {
  EXPECT_EQ(exif_orientation(with({})), 1);
  EXPECT_EQ(exif_orientation(with(exif(true, 0))), 1);
  EXPECT_EQ(exif_orientation(with(exif(true, 9))), 1);
  EXPECT_EQ(exif_orientation({}), 1);
}

/// Any bytes give an orientation, and none beyond the end is read (the sanitizers' build sees it).
TEST(Exif, DamageIsNoFault) {
  const File good = with(exif(false, 6));
  for (std::size_t bytes = 0; bytes <= good.size(); ++bytes) {
    const File cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(bytes));
    const int orientation = exif_orientation(cut);
    EXPECT_TRUE(orientation == 1 || orientation == 6) << bytes;
  }
  Rng rng(7, 0);
  for (int i = 0; i < 2000; ++i) {
    File spoilt = good;
    for (int k = 0; k < 3; ++k) {
      spoilt[rng.next() % std::min<std::size_t>(60, spoilt.size())] =
          static_cast<std::uint8_t>(rng.next());
    }
    const int orientation = exif_orientation(spoilt);
    EXPECT_TRUE(orientation >= 1 && orientation <= 8) << i;
  }
}

}  // namespace
}  // namespace polhode::platform::exif_test
