#include "camera/v4l2/convert.hpp"

#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <turbojpeg.h>

#include <cstdlib>
#include <cstring>

namespace polhode::platform::convert_test {
namespace {

constexpr int kWidth = 5;
constexpr int kHeight = 3;

OfferedFormat format_of(std::uint32_t fourcc, std::uint32_t padding) {
  const std::uint32_t row = row_bytes_of(*find_packing(fourcc), kWidth) + padding;
  return {.fourcc = fourcc,
          .width_px = kWidth,
          .height_px = kHeight,
          .row_bytes = row,
          .image_bytes = row * kHeight};
}

/// Bytes 1, 2, 3 ..., so that every position can be distinguished from every other.
std::vector<std::uint8_t> ramp(const OfferedFormat& format) {
  std::vector<std::uint8_t> bytes(format.image_bytes);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(1 + i);
  }
  return bytes;
}

std::uint16_t pixel16(const ImageView& view, int u, int v) {
  std::uint16_t value = 0;
  std::memcpy(&value, view.data + v * view.stride_bytes + 2 * u, sizeof value);
  return value;
}

TEST(Convert, GrayIsReadWhereItLies_PaddingAndAll) {
  const OfferedFormat format = format_of(V4L2_PIX_FMT_GREY, 3);
  const auto buffer = ramp(format);
  ImageView view;
  ASSERT_TRUE(GrayConverter(format).convert(buffer, &view));
  EXPECT_EQ(view.data, buffer.data());
  EXPECT_EQ(view.stride_bytes, kWidth + 3);
  EXPECT_EQ(view.format, PixelFormat::kGray8);
}

TEST(Convert, SixteenBitsAreReadWhereTheyLie) {
  const OfferedFormat format = format_of(V4L2_PIX_FMT_Y16, 2);
  const auto buffer = ramp(format);
  ImageView view;
  ASSERT_TRUE(GrayConverter(format).convert(buffer, &view));
  EXPECT_EQ(view.data, buffer.data());
  EXPECT_EQ(view.format, PixelFormat::kGray16);
  EXPECT_EQ(pixel16(view, 1, 2), buffer[2 * 12 + 2] + 256 * buffer[2 * 12 + 3]);
}

TEST(Convert, TenAndTwelveBitsFillTheUpperEnd) {
  for (const auto& [fourcc, bits] :
       {std::pair{V4L2_PIX_FMT_Y10, 10}, std::pair{V4L2_PIX_FMT_Y12, 12}}) {
    const OfferedFormat format = format_of(fourcc, 4);
    std::vector<std::uint8_t> buffer(format.image_bytes, 0xEE);  // padding that must not be seen
    const auto full = static_cast<std::uint16_t>((1 << bits) - 1);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const auto value = static_cast<std::uint16_t>(full - 7 * u - v);
        std::memcpy(&buffer[static_cast<std::size_t>(v) * format.row_bytes +
                            2 * static_cast<std::size_t>(u)],
                    &value,
                    2);
      }
    }
    GrayConverter converter(format);
    ImageView view;
    ASSERT_TRUE(converter.convert(buffer, &view));
    EXPECT_EQ(view.stride_bytes, 2 * kWidth);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        EXPECT_EQ(pixel16(view, u, v), (full - 7 * u - v) << (16 - bits)) << u << "," << v;
      }
    }
  }
}

TEST(Convert, LumaIsEveryOtherByte) {
  const OfferedFormat format = format_of(V4L2_PIX_FMT_YUYV, 1);
  const auto buffer = ramp(format);
  GrayConverter converter(format);
  ImageView view;
  ASSERT_TRUE(converter.convert(buffer, &view));
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      EXPECT_EQ(view.data[v * view.stride_bytes + u],
                buffer[static_cast<std::size_t>(11 * v + 2 * u)]);
    }
  }
}

TEST(Convert, ColourBecomesLuminance) {
  const OfferedFormat format = format_of(V4L2_PIX_FMT_RGB24, 0);
  std::vector<std::uint8_t> buffer(format.image_bytes, 0);
  const std::uint8_t colours[5][3] = {
      {255, 255, 255}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {10, 20, 30}};
  std::memcpy(buffer.data(), colours, sizeof colours);
  GrayConverter converter(format);
  ImageView view;
  ASSERT_TRUE(converter.convert(buffer, &view));
  // 0.299 R + 0.587 G + 0.114 B, rounded
  const std::uint8_t expected[5] = {255, 76, 150, 29, 18};
  EXPECT_EQ(std::memcmp(view.data, expected, 5), 0);
  EXPECT_EQ(view.data[kWidth], 0);
}

TEST(Convert, ABufferThatEndsEarlyIsRefused_OneByteDecides) {
  for (const auto& packing : pixel_packings()) {
    if (packing.packing == Packing::kCompressed) {
      continue;
    }
    const OfferedFormat format = format_of(packing.fourcc, 0);
    const auto buffer = ramp(format);
    GrayConverter converter(format);
    ImageView view;
    EXPECT_TRUE(converter.convert(buffer, &view)) << packing.name;
    EXPECT_FALSE(converter.convert(std::span(buffer).first(buffer.size() - 1), &view))
        << packing.name;
    EXPECT_FALSE(converter.convert({}, &view)) << packing.name;
  }
}

TEST(Convert, LumaMayComeAfterItsChroma_AndBlueBeforeRed) {
  const OfferedFormat format = format_of(V4L2_PIX_FMT_UYVY, 3);
  const auto buffer = ramp(format);
  GrayConverter converter(format);
  ImageView view;
  ASSERT_TRUE(converter.convert(buffer, &view));
  EXPECT_EQ(view.data[2 * view.stride_bytes + 4], buffer[2 * 13 + 2 * 4 + 1]);
  const OfferedFormat colour = format_of(V4L2_PIX_FMT_BGR24, 0);
  std::vector<std::uint8_t> red(colour.image_bytes, 0);
  red[2] = 255;
  GrayConverter of_colour(colour);
  ASSERT_TRUE(of_colour.convert(red, &view));
  EXPECT_EQ(view.data[0], 76);
  EXPECT_EQ(view.data[1], 0);
}

TEST(Convert, APlaneOfLumaIsReadWhereItLies_ChromaBehindItOrNot) {
  for (const std::uint32_t fourcc : {V4L2_PIX_FMT_NV12,
                                     V4L2_PIX_FMT_NV12M,
                                     V4L2_PIX_FMT_NV21,
                                     V4L2_PIX_FMT_NV16M,
                                     V4L2_PIX_FMT_YUV420}) {
    const OfferedFormat format = format_of(fourcc, 3);
    auto buffer = ramp(format);
    buffer.resize(buffer.size() * 3 / 2, 0x80);
    ImageView view;
    ASSERT_TRUE(GrayConverter(format).convert(buffer, &view));
    EXPECT_EQ(view.data, buffer.data());
    EXPECT_EQ(view.stride_bytes, kWidth + 3);
    EXPECT_EQ(view.format, PixelFormat::kGray8);
  }
}

/// Packs by the definition: upper eight bits of each pixel of a group, then the lower bits of all,
/// the first pixel's at the lowest place.
std::vector<std::uint8_t> packed(const std::vector<unsigned>& values, const PixelPacking& packing) {
  std::vector<std::uint8_t> bytes;
  const auto low_bits = static_cast<unsigned>(packing.bits) - 8U;
  for (std::size_t first = 0; first < values.size();
       first += static_cast<std::size_t>(packing.group_pixels)) {
    std::uint64_t lows = 0;
    for (unsigned i = 0; i < static_cast<unsigned>(packing.group_pixels); ++i) {
      const unsigned value = first + i < values.size() ? values[first + i] : 0U;
      bytes.push_back(static_cast<std::uint8_t>(value >> low_bits));
      lows |= std::uint64_t{value & ((1U << low_bits) - 1U)} << (low_bits * i);
    }
    for (int k = packing.group_pixels; k < packing.group_bytes; ++k, lows >>= 8U) {
      bytes.push_back(static_cast<std::uint8_t>(lows));
    }
  }
  return bytes;
}

TEST(Convert, PackedBitsFillTheUpperEnd) {
  for (const char* name : {"Y10P", "Y12P", "Y14P"}) {
    const PixelPacking& packing = *find_packing(name);
    const OfferedFormat format = format_of(packing.fourcc, 2);
    const auto full = (1U << static_cast<unsigned>(packing.bits)) - 1U;
    std::vector<std::uint8_t> buffer;
    for (unsigned v = 0; v < kHeight; ++v) {
      std::vector<unsigned> values;
      for (unsigned u = 0; u < kWidth; ++u) {
        values.push_back((full - 1237U * u - 311U * v) & full);
      }
      const std::vector<std::uint8_t> row = packed(values, packing);
      buffer.insert(buffer.end(), row.begin(), row.end());
      buffer.resize((v + 1) * format.row_bytes, 0xEE);  // padding that must not be seen
    }
    GrayConverter converter(format);
    ImageView view;
    ASSERT_TRUE(converter.convert(buffer, &view)) << name;
    EXPECT_EQ(view.format, PixelFormat::kGray16);
    for (unsigned v = 0; v < kHeight; ++v) {
      for (unsigned u = 0; u < kWidth; ++u) {
        EXPECT_EQ(pixel16(view, static_cast<int>(u), static_cast<int>(v)),
                  ((full - 1237U * u - 311U * v) & full) << (16 - packing.bits))
            << name << " " << u << "," << v;
      }
    }
  }
  // A row of MIPI RAW10, by hand: 0x3FF, 0x001, 0x200, 0x155.
  const std::uint8_t row[] = {0xFF, 0x00, 0x80, 0x55, 0b01'00'01'11};
  std::uint16_t wide[4];
  group_row(row, 4, *find_packing("Y10P"), reinterpret_cast<std::uint8_t*>(wide));
  EXPECT_EQ(wide[0], 0x3FF << 6);
  EXPECT_EQ(wide[1], 0x001 << 6);
  EXPECT_EQ(wide[2], 0x200 << 6);
  EXPECT_EQ(wide[3], 0x155 << 6);
}

class Jpeg : public testing::Test {
 protected:
  static constexpr int kSide = 64;

  Jpeg() {
    std::vector<std::uint8_t> gray(kSide * kSide);
    for (int i = 0; i < kSide * kSide; ++i) {
      gray[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(2 * (i / kSide) + i % kSide);
    }
    tjhandle coder = tjInitCompress();
    unsigned char* out = nullptr;
    unsigned long bytes = 0;
    tjCompress2(coder, gray.data(), kSide, 0, kSide, TJPF_GRAY, &out, &bytes, TJSAMP_GRAY, 95, 0);
    file_.assign(out, out + bytes);
    tjFree(out);
    tjDestroy(coder);
  }

  static OfferedFormat format(int side) {
    return {.fourcc = V4L2_PIX_FMT_MJPEG,
            .width_px = side,
            .height_px = side,
            .row_bytes = 0,
            .image_bytes = 100'000};
  }

  std::vector<std::uint8_t> file_;
};

TEST_F(Jpeg, IsDecodedToGray) {
  GrayConverter converter(format(kSide));
  ImageView view;
  ASSERT_TRUE(converter.convert(file_, &view));
  for (int v = 0; v < kSide; v += 9) {
    for (int u = 0; u < kSide; u += 7) {
      EXPECT_NEAR(view.data[v * view.stride_bytes + u], 2 * v + u, 3);  // of quality 95
    }
  }
}

TEST_F(Jpeg, TruncatedOrOfAnotherSizeOrNoJpegAtAll_IsRefused) {
  GrayConverter converter(format(kSide));
  ImageView view;
  EXPECT_FALSE(converter.convert(std::span(file_).first(file_.size() / 2), &view));
  EXPECT_FALSE(converter.convert(std::span(file_).first(1), &view));
  EXPECT_FALSE(converter.convert({}, &view));
  const std::vector<std::uint8_t> noise(4000, 0x5A);
  EXPECT_FALSE(converter.convert(noise, &view));
  EXPECT_FALSE(GrayConverter(format(kSide / 2)).convert(file_, &view));
  EXPECT_TRUE(converter.convert(file_, &view));  // the decoder is none the worse for it
}

}  // namespace
}  // namespace polhode::platform::convert_test
