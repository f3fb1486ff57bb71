#include "camera/v4l2/jpeg_decoder.hpp"

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <atomic>
#include <cstdlib>
#include <vector>

namespace {

std::atomic<std::uint64_t> heap_calls{0};

}  // namespace

#if !defined(__SANITIZE_ADDRESS__)
// Every request for heap in this program and the libraries below it goes through here.
extern "C" void* __libc_malloc(std::size_t bytes);
extern "C" void* malloc(std::size_t bytes) {
  heap_calls.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(bytes);
}
#endif

namespace polhode::platform::jpeg_decoder_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes image(int width_px, int height_px) {
  Bytes rgb(3 * static_cast<std::size_t>(width_px * height_px));
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    state = 1664525U * state + 1013904223U;
    rgb[i] = static_cast<std::uint8_t>((i / 3 % 251 + (state >> 28U)) & 0xFFU);
  }
  return rgb;
}

Bytes compressed(int width_px, int height_px, int subsampling, int flags = 0) {
  const Bytes rgb = image(width_px, height_px);
  tjhandle coder = tjInitCompress();
  unsigned char* out = nullptr;
  unsigned long bytes = 0;
  EXPECT_EQ(tjCompress2(coder,
                        rgb.data(),
                        width_px,
                        0,
                        height_px,
                        TJPF_RGB,
                        &out,
                        &bytes,
                        subsampling,
                        90,
                        flags),
            0);
  Bytes file(out, out + bytes);
  tjFree(out);
  tjDestroy(coder);
  return file;
}

Bytes by_turbojpeg(const Bytes& file, int width_px, int height_px) {
  Bytes gray(static_cast<std::size_t>(width_px * height_px));
  tjhandle decoder = tjInitDecompress();
  EXPECT_EQ(tjDecompress2(decoder,
                          file.data(),
                          file.size(),
                          gray.data(),
                          width_px,
                          0,
                          height_px,
                          TJPF_GRAY,
                          TJFLAG_ACCURATEDCT),
            0);
  tjDestroy(decoder);
  return gray;
}

class Subsamplings : public ::testing::TestWithParam<int> {};

TEST_P(Subsamplings, GiveTheLibrarysOwnPixels_AtAnySize) {
  for (const auto& [width_px, height_px] :
       {std::pair{64, 48}, {65, 49}, {1, 1}, {640, 480}, {1920, 1080}}) {
    const Bytes file = compressed(width_px, height_px, GetParam());
    JpegDecoder decoder(width_px, height_px);
    Bytes gray(static_cast<std::size_t>(width_px * height_px));
    ASSERT_TRUE(decoder.decode(file, gray.data())) << width_px;
    EXPECT_EQ(gray, by_turbojpeg(file, width_px, height_px)) << width_px;
    EXPECT_LT(2 * decoder.peak_bytes(), decoder.memory_bytes()) << width_px;
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfChroma,
    Subsamplings,
    ::testing::Values(TJSAMP_GRAY, TJSAMP_444, TJSAMP_422, TJSAMP_420, TJSAMP_440, TJSAMP_411));

#if !defined(__SANITIZE_ADDRESS__)
TEST(JpegDecoder, TakesNoHeapOnceItIsMade_GoodImagesOrBad) {
  const Bytes file = compressed(640, 480, TJSAMP_422);
  const Bytes other = compressed(320, 240, TJSAMP_422);
  Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(file.size() / 2));
  Bytes gray(640 * 480);
  JpegDecoder decoder(640, 480);
  const std::uint64_t before = heap_calls;
  for (int i = 0; i < 100; ++i) {
    const bool good = decoder.decode(file, gray.data());
    const bool bad = decoder.decode(cut, gray.data()) || decoder.decode(other, gray.data());
    if (!good || bad) {
      std::abort();  // no text, which would take heap
    }
  }
  EXPECT_EQ(heap_calls - before, 0U);
}
#endif

TEST(JpegDecoder, TakesWhatCamerasSend_StrayBytesAndNoEndMarker) {
  const Bytes file = compressed(320, 240, TJSAMP_422);
  JpegDecoder decoder(320, 240);
  Bytes whole(320 * 240);
  ASSERT_TRUE(decoder.decode(file, whole.data()));
  Bytes stray = file;
  stray.insert(stray.end() - 2, 1000, 0);  // before the end marker
  for (const Bytes& sent : {stray, Bytes(file.begin(), file.end() - 2)}) {
    Bytes gray(320 * 240);
    ASSERT_TRUE(decoder.decode(sent, gray.data()));
    EXPECT_EQ(gray, whole);
  }
  Bytes gray(320 * 240);
  EXPECT_FALSE(decoder.decode(Bytes(file.begin(), file.end() - 60), gray.data()));
}

TEST(JpegDecoder, RefusesWhatNoCameraSends_AndGoesOn) {
  const Bytes file = compressed(320, 240, TJSAMP_420);
  JpegDecoder decoder(320, 240);
  Bytes gray(320 * 240);
  EXPECT_FALSE(decoder.decode(compressed(320, 240, TJSAMP_420, TJFLAG_PROGRESSIVE), gray.data()));
  EXPECT_FALSE(decoder.decode({}, gray.data()));
  EXPECT_FALSE(decoder.decode(Bytes(5000, 0x5A), gray.data()));
  EXPECT_TRUE(decoder.decode(file, gray.data()));
}

TEST(JpegDecoder, OfDamagedImagesWritesNowhereElse) {
  const Bytes file = compressed(160, 120, TJSAMP_420);
  JpegDecoder decoder(160, 120);
  constexpr std::size_t kPixels = 160 * 120;
  constexpr std::size_t kMargin = 4096;
  Bytes gray(kPixels + kMargin, 0x77);
  std::uint32_t state = 7;
  const auto random = [&state] { return (state = 1664525U * state + 1013904223U) >> 8U; };
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Bytes damaged = file;
    for (std::uint32_t n = 1 + random() % 8; n > 0; --n) {
      damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
    }
    refused += decoder.decode(damaged, gray.data()) ? 0 : 1;
  }
  EXPECT_GT(refused, 100);
  EXPECT_EQ(Bytes(gray.begin() + kPixels, gray.end()), Bytes(kMargin, 0x77));
  EXPECT_TRUE(decoder.decode(file, gray.data()));
}

}  // namespace
}  // namespace polhode::platform::jpeg_decoder_test
