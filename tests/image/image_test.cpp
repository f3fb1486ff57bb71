#include "image/image.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "base/rng.hpp"

namespace polhode::image_test {
namespace {

TEST(ImportFrame, CopiesEveryPixel_WhenRowsAreLongerThanTheImage) {
  constexpr int kWidth = 7;
  constexpr int kHeight = 5;
  constexpr int kStride = 11;
  std::vector<std::uint8_t> memory(kStride * kHeight, 0xEE);
  Rng rng(1, 0);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      memory[static_cast<std::size_t>(row * kStride + column)] =
          static_cast<std::uint8_t>(rng.below(256));
    }
  }
  cv::Mat gray;
  import_frame(
      {.data = memory.data(), .width_px = kWidth, .height_px = kHeight, .stride_bytes = kStride},
      &gray);
  ASSERT_EQ(gray.type(), CV_8UC1);
  ASSERT_EQ(gray.size(), cv::Size(kWidth, kHeight));
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      EXPECT_EQ(gray.at<std::uint8_t>(row, column),
                memory[static_cast<std::size_t>(row * kStride + column)]);
    }
  }
}

TEST(ImportFrame, KeepsTheUpperByte_WhenPixelsHave16Bits_AtAnyAlignment) {
  const std::vector<std::uint16_t> values{0x0000, 0x00FF, 0x0100, 0x7F80, 0xFF00, 0xFFFF};
  constexpr int kWidth = 3;
  constexpr std::size_t kStride = 9;  // odd: the second row's pixels are not aligned
  std::vector<std::uint8_t> memory(2 * kStride, 0xEE);
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::memcpy(memory.data() + (i / kWidth) * kStride + 2 * (i % kWidth), &values[i], 2);
  }
  cv::Mat gray;
  import_frame({.data = memory.data(),
                .width_px = kWidth,
                .height_px = 2,
                .stride_bytes = kStride,
                .format = PixelFormat::kGray16},
               &gray);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(gray.at<std::uint8_t>(static_cast<int>(i) / kWidth, static_cast<int>(i) % kWidth),
              values[i] >> 8U);
  }
}

TEST(ImportFrame, OwnsItsPixels_SoThatTheCameraMayReuseTheMemory) {
  std::vector<std::uint8_t> memory(16, 10);
  cv::Mat gray;
  const ImageView view{.data = memory.data(), .width_px = 4, .height_px = 4, .stride_bytes = 4};
  import_frame(view, &gray);
  const std::uint8_t* first = gray.data;
  std::fill(memory.begin(), memory.end(), std::uint8_t{20});
  EXPECT_EQ(gray.at<std::uint8_t>(3, 3), 10);
  import_frame(view, &gray);
  EXPECT_EQ(gray.at<std::uint8_t>(3, 3), 20);
  EXPECT_EQ(gray.data, first) << "the same size takes no new memory";
}

}  // namespace
}  // namespace polhode::image_test
