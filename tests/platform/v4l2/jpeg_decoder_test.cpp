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
extern "C" void* __libc_malloc(std::size_t octets);
extern "C" void* malloc(std::size_t octets) {
  heap_calls.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(octets);
}
#endif

namespace polhode::platform::jpeg_decoder_test {
namespace {

using Octets = std::vector<std::uint8_t>;

Octets image(int width_px, int height_px) {
  Octets rgb(3 * static_cast<std::size_t>(width_px * height_px));
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    state = 1664525U * state + 1013904223U;
    rgb[i] = static_cast<std::uint8_t>((i / 3 % 251 + (state >> 28U)) & 0xFFU);
  }
  return rgb;
}

Octets compressed(int width_px, int height_px, int subsampling, int flags = 0) {
  const Octets rgb = image(width_px, height_px);
  tjhandle coder = tjInitCompress();
  unsigned char* out = nullptr;
  unsigned long octets = 0;
  EXPECT_EQ(tjCompress2(coder,
                        rgb.data(),
                        width_px,
                        0,
                        height_px,
                        TJPF_RGB,
                        &out,
                        &octets,
                        subsampling,
                        90,
                        flags),
            0);
  Octets file(out, out + octets);
  tjFree(out);
  tjDestroy(coder);
  return file;
}

Octets by_turbojpeg(const Octets& file, int width_px, int height_px) {
  Octets gray(static_cast<std::size_t>(width_px * height_px));
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
    const Octets file = compressed(width_px, height_px, GetParam());
    JpegDecoder decoder(width_px, height_px);
    Octets gray(static_cast<std::size_t>(width_px * height_px));
    ASSERT_TRUE(decoder.decode(file, gray.data())) << width_px;
    EXPECT_EQ(gray, by_turbojpeg(file, width_px, height_px)) << width_px;
    EXPECT_LT(2 * decoder.peak_octets(), decoder.memory_octets()) << width_px;
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfChroma,
    Subsamplings,
    ::testing::Values(TJSAMP_GRAY, TJSAMP_444, TJSAMP_422, TJSAMP_420, TJSAMP_440, TJSAMP_411));

#if !defined(__SANITIZE_ADDRESS__)
TEST(JpegDecoder, TakesNoHeapOnceItIsMade_GoodImagesOrBad) {
  const Octets file = compressed(640, 480, TJSAMP_422);
  const Octets other = compressed(320, 240, TJSAMP_422);
  Octets cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(file.size() / 2));
  Octets gray(640 * 480);
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

TEST(JpegDecoder, TakesWhatCamerasSend_StrayOctetsAndNoEndMarker) {
  const Octets file = compressed(320, 240, TJSAMP_422);
  JpegDecoder decoder(320, 240);
  Octets whole(320 * 240);
  ASSERT_TRUE(decoder.decode(file, whole.data()));
  Octets stray = file;
  stray.insert(stray.end() - 2, 1000, 0);  // before the end marker
  for (const Octets& sent : {stray, Octets(file.begin(), file.end() - 2)}) {
    Octets gray(320 * 240);
    ASSERT_TRUE(decoder.decode(sent, gray.data()));
    EXPECT_EQ(gray, whole);
  }
  Octets gray(320 * 240);
  EXPECT_FALSE(decoder.decode(Octets(file.begin(), file.end() - 60), gray.data()));
}

TEST(JpegDecoder, RefusesWhatNoCameraSends_AndGoesOn) {
  const Octets file = compressed(320, 240, TJSAMP_420);
  JpegDecoder decoder(320, 240);
  Octets gray(320 * 240);
  EXPECT_FALSE(decoder.decode(compressed(320, 240, TJSAMP_420, TJFLAG_PROGRESSIVE), gray.data()));
  EXPECT_FALSE(decoder.decode({}, gray.data()));
  EXPECT_FALSE(decoder.decode(Octets(5000, 0x5A), gray.data()));
  EXPECT_TRUE(decoder.decode(file, gray.data()));
}

TEST(JpegDecoder, OfDamagedImagesWritesNowhereElse) {
  const Octets file = compressed(160, 120, TJSAMP_420);
  JpegDecoder decoder(160, 120);
  constexpr std::size_t kPixels = 160 * 120;
  constexpr std::size_t kMargin = 4096;
  Octets gray(kPixels + kMargin, 0x77);
  std::uint32_t state = 7;
  const auto random = [&state] { return (state = 1664525U * state + 1013904223U) >> 8U; };
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Octets damaged = file;
    for (std::uint32_t n = 1 + random() % 8; n > 0; --n) {
      damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
    }
    refused += decoder.decode(damaged, gray.data()) ? 0 : 1;
  }
  EXPECT_GT(refused, 100);
  EXPECT_EQ(Octets(gray.begin() + kPixels, gray.end()), Octets(kMargin, 0x77));
  EXPECT_TRUE(decoder.decode(file, gray.data()));
}

}  // namespace
}  // namespace polhode::platform::jpeg_decoder_test
