#include "camera/replay/decode.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "encode.hpp"

namespace polhode::platform::decode_test {
namespace {

constexpr int kWidth = 37;
constexpr int kHeight = 23;
constexpr std::size_t kCount = kWidth * kHeight;

/// Smooth, so that JPEG keeps it, and different in every pixel's neighbourhood.
File gray_samples() {
  File samples;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      samples.push_back(static_cast<std::uint8_t>(20 + 4 * x + 3 * y));
    }
  }
  return samples;
}

File big_endian_samples() {
  File samples;
  for (const std::uint8_t value : gray_samples()) {
    samples.push_back(value);
    samples.push_back(static_cast<std::uint8_t>(255 - value));
  }
  return samples;
}

std::uint16_t deep_pixel(const DecodedImage& image, std::size_t index) {
  std::uint16_t value = 0;
  std::memcpy(&value, image.pixels.data() + 2 * index, sizeof value);
  return value;
}

DecodedImage decoded(const File& file) {
  DecodedImage image;
  EXPECT_EQ(decode(file, image), std::nullopt);
  EXPECT_EQ(image.header.width_px, kWidth);
  EXPECT_EQ(image.header.height_px, kHeight);
  return image;
}

TEST(Decode, Png_KeepsGrayValues_WithAndWithoutInterlacing) {
  const File samples = gray_samples();
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    const PngShape shape{.width = kWidth, .height = kHeight, .interlace = interlace};
    EXPECT_EQ(decoded(encode_png(shape, samples)).pixels, samples);
  }
}

TEST(Decode, Png_Keeps16BitValues_InTheMachinesOrder) {
  const File samples = big_endian_samples();
  const DecodedImage image =
      decoded(encode_png({.width = kWidth, .height = kHeight, .depth = 16}, samples));
  ASSERT_EQ(image.header.format, PixelFormat::kGray16);
  EXPECT_EQ(image.view().stride_bytes, 2 * kWidth);
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_EQ(deep_pixel(image, i), samples[2 * i] * 256 + samples[2 * i + 1]);
  }
}

TEST(Decode, Png_TurnsColourIntoLuminance_AndDropsAlpha) {
  File rgba;
  for (std::size_t i = 0; i < kCount; ++i) {
    rgba.insert(rgba.end(), {200, 100, 50, static_cast<std::uint8_t>(i)});
  }
  const PngShape shape{.width = kWidth, .height = kHeight, .colour_type = PNG_COLOR_TYPE_RGB_ALPHA};
  // 0.299 * 200 + 0.587 * 100 + 0.114 * 50 = 124.2
  EXPECT_EQ(decoded(encode_png(shape, rgba)).pixels, File(kCount, 124));
}

TEST(Decode, Png_InterlacedColourIsWhatItIsWithoutInterlacing) {
  for (const int depth : {8, 16}) {
    File rgb;
    for (std::size_t i = 0; i < 3 * kCount * static_cast<std::size_t>(depth / 8); ++i) {
      rgb.push_back(static_cast<std::uint8_t>(i * i % 251));
    }
    PngShape shape{
        .width = kWidth, .height = kHeight, .depth = depth, .colour_type = PNG_COLOR_TYPE_RGB};
    const File plain = decoded(encode_png(shape, rgb)).pixels;
    shape.interlace = PNG_INTERLACE_ADAM7;
    EXPECT_EQ(decoded(encode_png(shape, rgb)).pixels, plain) << depth;
  }
}

TEST(Decode, Png_OfOnePixelIsReadInterlaced) {
  DecodedImage image;
  const PngShape shape{.width = 1, .height = 1, .interlace = PNG_INTERLACE_ADAM7};
  ASSERT_EQ(decode(encode_png(shape, {77}), image), std::nullopt);
  EXPECT_EQ(image.pixels, File{77});
}

TEST(Decode, Jpeg_InSeveralScansTellsWhatItsDecoderTakes) {
  ImageHeader header;
  ASSERT_EQ(read_header(encode_jpeg(kWidth, kHeight, gray_samples()), header), std::nullopt);
  EXPECT_EQ(header.decoder_bytes, 0U);
  const File progressive = encode_jpeg(kWidth, kHeight, gray_samples(), TJFLAG_PROGRESSIVE);
  ASSERT_EQ(read_header(progressive, header), std::nullopt);
  EXPECT_GE(header.decoder_bytes, 2 * 40U * 24U);  // whole blocks of 8 x 8, 16 bits each
  EXPECT_LE(header.decoder_bytes, 2 * (kWidth + 32U) * (kHeight + 32U));
  EXPECT_EQ(decoded(progressive).header.width_px, kWidth);
}

TEST(Decode, Png_GrayStoredAsColour_KeepsItsValues) {
  const File samples = gray_samples();
  File rgb;
  for (const std::uint8_t value : samples) {
    rgb.insert(rgb.end(), {value, value, value});
  }
  const PngShape shape{.width = kWidth, .height = kHeight, .colour_type = PNG_COLOR_TYPE_RGB};
  EXPECT_EQ(decoded(encode_png(shape, rgb)).pixels, samples);
}

TEST(Decode, Png_ReadsPalettes) {
  const PngShape shape{.width = kWidth,
                       .height = kHeight,
                       .colour_type = PNG_COLOR_TYPE_PALETTE,
                       .palette = {{10, 10, 10}, {250, 250, 250}}};
  File indices(kCount, 0);
  indices[5] = 1;
  const DecodedImage image = decoded(encode_png(shape, indices));
  EXPECT_EQ(image.pixels[4], 10);
  EXPECT_EQ(image.pixels[5], 250);
}

TEST(Decode, Jpeg_IsNearTheOriginal) {
  const File samples = gray_samples();
  const DecodedImage image = decoded(encode_jpeg(kWidth, kHeight, samples));
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_NEAR(
        image.pixels[i], samples[i], 8);  // quality 95 quantises the gradient by a few steps
  }
}

TEST(Decode, Pgm_Keeps8And16BitValues) {
  EXPECT_EQ(decoded(encode_pgm(kWidth, kHeight, 255, gray_samples())).pixels, gray_samples());
  const DecodedImage deep = decoded(encode_pgm(kWidth, kHeight, 65535, big_endian_samples()));
  ASSERT_EQ(deep.header.format, PixelFormat::kGray16);
  EXPECT_EQ(deep_pixel(deep, 3), big_endian_samples()[6] * 256 + big_endian_samples()[7]);
}

TEST(Decode, Pgm_ScalesAnotherMaxvalToFullScale) {
  File ten_bits;
  for (std::size_t i = 0; i < kCount; ++i) {
    ten_bits.insert(ten_bits.end(), {0x03, 0xFF});
  }
  EXPECT_EQ(deep_pixel(decoded(encode_pgm(kWidth, kHeight, 1023, ten_bits)), 0), 65535);
}

// verifies: PRG-06
TEST(Decode, EveryTruncationIsRefused_AndReportsIt_WhereAPixelIsMissing) {
  const PngShape shape{.width = kWidth, .height = kHeight};
  const File files[] = {encode_png(shape, gray_samples()),
                        encode_jpeg(kWidth, kHeight, gray_samples()),
                        encode_pgm(kWidth, kHeight, 255, gray_samples())};
  for (const File& file : files) {
    const DecodedImage whole = decoded(file);
    for (std::size_t size = 0; size < file.size(); ++size) {
      DecodedImage image;
      const Refusal refusal = decode(Bytes(file).first(size), image);
      if (!refusal) {  // a JPEG without its end marker: all of the image is there
        ASSERT_EQ(&file, &files[1]);
        ASSERT_GE(size + 2, file.size());
        ASSERT_EQ(image.pixels, whole.pixels);
        continue;
      }
      ASSERT_TRUE(refusal.has_value()) << size << " of " << file.size() << " octets";
      ASSERT_FALSE(refusal->empty());
    }
  }
}

/// Bytes put before the marker FF xx.
File with_stray(File file, std::uint8_t marker, const File& stray) {
  for (std::size_t i = file.size() - 2; i > 0; --i) {
    if (file[i] == 0xFF && file[i + 1] == marker) {
      file.insert(file.begin() + static_cast<std::ptrdiff_t>(i), stray.begin(), stray.end());
      return file;
    }
  }
  ADD_FAILURE() << "no such marker";
  return file;
}

TEST(Decode, AJpegsStrayBytesAreNoDamage_DataThatIsNotUnderstoodIs) {
  constexpr std::uint8_t kEnd = 0xD9;
  const File file = encode_jpeg(kWidth, kHeight, gray_samples());
  const DecodedImage whole = decoded(file);
  EXPECT_EQ(decoded(with_stray(file, kEnd, {0})).pixels, whole.pixels);
  EXPECT_EQ(decoded(with_stray(file, kEnd, File(3000, 0))).pixels, whole.pixels);  // filled up
  File data(300);
  for (std::size_t i = 0; i < data.size(); ++i) {
    data[i] = static_cast<std::uint8_t>(i % 200);
  }
  DecodedImage image;
  EXPECT_TRUE(decode(with_stray(file, kEnd, data), image).has_value());
}

TEST(Decode, AProgressiveJpegThatLacksScansIsRefused) {
  const File file = encode_jpeg(kWidth, kHeight, gray_samples(), TJFLAG_PROGRESSIVE);
  std::size_t last_scan = 0;
  for (std::size_t i = 0; i + 1 < file.size(); ++i) {
    last_scan = file[i] == 0xFF && file[i + 1] == 0xDA ? i : last_scan;
  }
  ASSERT_GT(last_scan, 0U);
  DecodedImage image;
  EXPECT_TRUE(decode(Bytes(file).first(last_scan), image).has_value());
}

TEST(Decode, DamagedBytesNeverCrash_AndPngNoticesThem) {
  const File png = encode_png({.width = kWidth, .height = kHeight}, gray_samples());
  const File jpeg = encode_jpeg(kWidth, kHeight, gray_samples());
  for (const File& file : {png, jpeg}) {
    for (std::size_t i = 0; i < file.size(); ++i) {
      File damaged = file;
      damaged[i] ^= 0x55U;
      DecodedImage image;
      ImageHeader header;
      // The camera looks at the header first and decodes only what has its size.
      if (read_header(damaged, header) || header.width_px != kWidth ||
          header.height_px != kHeight) {
        continue;
      }
      const Refusal refusal = decode(damaged, image);
      const bool in_data = file == png && i > 40 && i + 20 < file.size();
      EXPECT_TRUE(!in_data || refusal) << "octet " << i;
    }
  }
}

TEST(Decode, OtherContentIsRefused) {
  DecodedImage image;
  const std::string text = "GIF89a and so on";
  EXPECT_EQ(decode(File(text.begin(), text.end()), image),
            "not a PNG, JPEG or binary PGM (P5) image");
  EXPECT_EQ(decode({}, image), "the file is empty");
}

TEST(Decode, BuffersAreUsedAgain) {
  const File file = encode_png({.width = kWidth, .height = kHeight}, gray_samples());
  DecodedImage image;
  ASSERT_FALSE(decode(file, image));
  const std::uint8_t* before = image.pixels.data();
  ASSERT_FALSE(decode(file, image));
  EXPECT_EQ(image.pixels.data(), before);
}

}  // namespace
}  // namespace polhode::platform::decode_test
