#include "camera/v4l2/formats.hpp"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <limits>

namespace polhode::platform::formats_test {
namespace {

OfferedFormat offer(std::uint32_t fourcc,
                    std::uint32_t bytes_per_pixel,
                    int width = 640,
                    int height = 480) {
  const std::uint32_t row = bytes_per_pixel * static_cast<std::uint32_t>(width);
  return {.fourcc = fourcc,
          .width_px = width,
          .height_px = height,
          .row_bytes = row,
          .image_bytes = row * static_cast<std::uint32_t>(height)};
}

const FormatRequest kRequest{.width_px = 640, .height_px = 480};

TEST(ChooseFormat, TakesWhatNeedsNoConversionFirst_WhateverTheOrderOfTheOffer) {
  std::vector<OfferedFormat> offered{{V4L2_PIX_FMT_MJPEG, 640, 480, 0, 100000},
                                     offer(V4L2_PIX_FMT_YUYV, 2),
                                     offer(V4L2_PIX_FMT_Y10, 2),
                                     offer(V4L2_PIX_FMT_GREY, 1)};
  EXPECT_EQ(choose_format(offered, kRequest), 3U);
  offered.pop_back();
  EXPECT_EQ(choose_format(offered, kRequest), 2U);
  offered.pop_back();
  EXPECT_EQ(choose_format(offered, kRequest), 1U);
  offered.pop_back();
  EXPECT_EQ(choose_format(offered, kRequest), 0U);
}

TEST(ChooseFormat, TakesNoOtherSizeThanTheCamerasCalibration) {
  const std::vector<OfferedFormat> offered{offer(V4L2_PIX_FMT_GREY, 1, 1280, 960)};
  EXPECT_FALSE(choose_format(offered, kRequest));
}

TEST(ChooseFormat, TakesTheFormatThatIsAskedFor_OrNone) {
  const std::vector<OfferedFormat> offered{offer(V4L2_PIX_FMT_GREY, 1),
                                           offer(V4L2_PIX_FMT_YUYV, 2)};
  FormatRequest request = kRequest;
  request.fourcc = V4L2_PIX_FMT_YUYV;
  EXPECT_EQ(choose_format(offered, request), 1U);
  request.fourcc = V4L2_PIX_FMT_Y16;
  EXPECT_FALSE(choose_format(offered, request));
}

TEST(ChooseFormat, RefusesRowsOrImagesThatAreTooShortForTheirSize) {
  OfferedFormat format = offer(V4L2_PIX_FMT_Y16, 2);
  EXPECT_TRUE(consistent(format));
  format.row_bytes -= 1;
  EXPECT_FALSE(consistent(format));
  format = offer(V4L2_PIX_FMT_Y16, 2);
  format.image_bytes -= 1;
  EXPECT_FALSE(consistent(format));
  format = offer(V4L2_PIX_FMT_GREY, 1);
  format.image_bytes = std::numeric_limits<std::uint32_t>::max();
  EXPECT_FALSE(consistent(format));
  format = offer(V4L2_PIX_FMT_GREY, 1);
  format.width_px = -640;
  EXPECT_FALSE(consistent(format));
  EXPECT_FALSE(consistent(offer(V4L2_PIX_FMT_SBGGR8, 1)));
  format = offer(V4L2_PIX_FMT_GREY, 1);
  format.field = V4L2_FIELD_INTERLACED;
  EXPECT_FALSE(consistent(format));
}

TEST(ChooseFormat, RowsOfPackedBitsEndWithAWholeGroup) {
  EXPECT_EQ(row_bytes_of(*find_packing("Y10P"), 640), 800U);
  EXPECT_EQ(row_bytes_of(*find_packing("Y10P"), 5), 10U);
  EXPECT_EQ(row_bytes_of(*find_packing("Y12P"), 640), 960U);
  EXPECT_EQ(row_bytes_of(*find_packing("NV12"), 640), 640U);
  EXPECT_EQ(row_bytes_of(*find_packing("BGR24"), 640), 1920U);
}

TEST(ChooseFormat, NothingOnOfferIsNothing) { EXPECT_FALSE(choose_format({}, kRequest)); }

TEST(ChooseInterval, TakesTheNearestByRatio_AndNoneThatIsZero) {
  const std::vector<Interval> offered{{0, 30}, {1, 5}, {1, 15}, {1, 0}, {1, 60}};
  EXPECT_EQ(choose_interval(offered, 20.0), 2U);
  EXPECT_EQ(choose_interval(offered, 50.0), 4U);
  EXPECT_EQ(choose_interval(offered, 1.0), 1U);
  EXPECT_FALSE(choose_interval(std::vector<Interval>{{0, 0}}, 20.0));
}

TEST(Interval, OfARateGivesTheRateBack) {
  for (const double hz : {0.5, 10.0, 29.97, 120.0}) {
    EXPECT_NEAR(rate_hz(interval_of(hz)), hz, 5e-4) << hz;  // denominators of a thousandth
  }
}

TEST(Fourcc, IsReadable_WithBigEndianMarked) {
  EXPECT_EQ(fourcc_text(V4L2_PIX_FMT_GREY), "GREY");
  EXPECT_EQ(fourcc_text(V4L2_PIX_FMT_Y16), "Y16");
  EXPECT_EQ(fourcc_text(V4L2_PIX_FMT_Y16_BE), "Y16-BE");
  EXPECT_EQ(fourcc_text(0x01020304), "....");
  EXPECT_EQ(find_packing("MJPEG")->fourcc, V4L2_PIX_FMT_MJPEG);
  EXPECT_EQ(find_packing("nothing"), nullptr);
}

}  // namespace
}  // namespace polhode::platform::formats_test
