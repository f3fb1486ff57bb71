// A Bayer sensor's mosaic in gray images: found, distinguished from texture, levelled.
#include "camera/replay/mosaic.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "base/rng.hpp"

namespace polhode::platform::mosaic_test {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 128;
constexpr double kRed = 0.5;   // of green
constexpr double kBlue = 0.7;  // of green

/// Light of a smooth body, 60 to 180 of 255.
double light(int u, int v) { return 60.0 + 120.0 * (u + v) / (kWidth + kHeight); }

/// Which part of the light a pixel of an RGGB mosaic passes.
double passed(int u, int v) {
  const bool green = (u + v) % 2 == 1;
  return green ? 1.0 : u % 2 == 0 ? kRed : kBlue;
}

template <typename Level>
DecodedImage picture(const Level& level) {
  DecodedImage image;
  image.header = {.width_px = kWidth, .height_px = kHeight};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      image.pixels.push_back(static_cast<std::uint8_t>(level(u, v)));
    }
  }
  return image;
}

DecodedImage bayer() {
  return picture([](int u, int v) { return light(u, v) * passed(u, v); });
}

TEST(Mosaic, IsFound_WithItsContrast) {
  const auto cells = mosaic_of(bayer());
  ASSERT_TRUE(cells.has_value());
  const double mean = (2.0 + kRed + kBlue) / 4.0;
  EXPECT_NEAR(contrast_of(*cells), (1.0 - kRed) / mean, 0.03);
}

TEST(Mosaic, IsNotFoundInGrayLightOrInNoise) {
  EXPECT_FALSE(mosaic_of(picture(light)).has_value());
  Rng rng(5, 0);
  EXPECT_FALSE(mosaic_of(picture([&](int, int) { return 80.0 + 80.0 * rng.uniform(); })));
}

TEST(Mosaic, IsNotFoundInTheDark) {
  EXPECT_FALSE(mosaic_of(picture([](int, int) { return 0.0; })).has_value());
}

TEST(Mosaic, IsLevelledToTheMeanOfItsColours) {
  DecodedImage image = bayer();
  MosaicFilter(kWidth).level(&image);
  const double mean = (2.0 + kRed + kBlue) / 4.0;
  for (int v = 2; v < kHeight - 2; ++v) {
    for (int u = 2; u < kWidth - 2; ++u) {
      ASSERT_NEAR(image.pixels[static_cast<std::size_t>(v * kWidth + u)], mean * light(u, v), 3.0);
    }
  }
  EXPECT_FALSE(mosaic_of(image).has_value());
}

TEST(Mosaic, OfSixteenBitsIsLevelledAlike) {
  DecodedImage wide;
  wide.header = {.width_px = kWidth, .height_px = kHeight, .format = PixelFormat::kGray16};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto level = static_cast<std::uint16_t>(200.0 * light(u, v) * passed(u, v));
      std::uint8_t bytes[2];
      std::memcpy(bytes, &level, sizeof level);
      wide.pixels.insert(wide.pixels.end(), bytes, bytes + 2);
    }
  }
  ASSERT_TRUE(mosaic_of(wide).has_value());
  MosaicFilter(kWidth).level(&wide);
  EXPECT_FALSE(mosaic_of(wide).has_value());
}

}  // namespace
}  // namespace polhode::platform::mosaic_test
