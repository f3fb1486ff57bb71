#include "features/scale_space.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "base/rng.hpp"
#include "features/resample.hpp"

namespace polhode::sift::scale_space_test {
namespace {

/// A plane with memory of its own.
struct OwnedPlane {
  std::vector<float> memory;
  Plane plane;
};

OwnedPlane image(int width, int height) {
  OwnedPlane p;
  p.memory.resize(static_cast<std::size_t>(stride_of(width) * height));
  p.plane = {.data = p.memory.data(), .width = width, .height = height, .stride = stride_of(width)};
  return p;
}

OwnedPlane noise(int width, int height) {
  Rng rng(31, 0);
  OwnedPlane p = image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      p.plane.row(y)[x] = static_cast<float>(255.0 * rng.uniform());
    }
  }
  return p;
}

int mirrored(int i, int size) {
  const int period = 2 * (size - 1);
  const int folded = ((i % period) + period) % period;
  return std::min(folded, period - folded);
}

double kernel_at(const GaussianKernel& kernel, int offset) {
  return static_cast<double>(kernel.weight[static_cast<std::size_t>(std::abs(offset))]);
}

TEST(GaussianKernel, HasSumOne_AndTheVarianceAskedFor) {
  for (const double sigma_px : {0.9, 1.5, 3.1}) {
    const GaussianKernel kernel = gaussian_kernel(sigma_px);
    double sum = 0.0;
    double variance = 0.0;
    for (int k = -kernel.radius; k <= kernel.radius; ++k) {
      sum += kernel_at(kernel, k);
      variance += k * k * kernel_at(kernel, k);
    }
    EXPECT_NEAR(sum, 1.0, 1e-6);
    // Cutting at 3.2 sigma takes 1.5 % of the variance away. (Under 0.8 px sampling takes more.)
    EXPECT_NEAR(variance, sigma_px * sigma_px, 0.04 * sigma_px * sigma_px) << sigma_px;
  }
}

TEST(Blur, EqualsTheSumOverAllPairs_WithAMirrorAtTheBorder) {
  const OwnedPlane in = noise(37, 21);
  const OwnedPlane out = image(37, 21);
  const GaussianKernel kernel = gaussian_kernel(2.3);
  const auto scratch = std::make_unique<BlurRow>();
  blur(in.plane, kernel, scratch.get(), out.plane);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 37; ++x) {
      double sum = 0.0;
      for (int j = -kernel.radius; j <= kernel.radius; ++j) {
        for (int i = -kernel.radius; i <= kernel.radius; ++i) {
          sum += kernel_at(kernel, i) * kernel_at(kernel, j) *
                 static_cast<double>(in.plane.row(mirrored(y + j, 21))[mirrored(x + i, 37)]);
        }
      }
      // Single precision: some 30 sums of values up to 255.
      ASSERT_NEAR(static_cast<double>(out.plane.row(y)[x]), sum, 5e-4) << x << ", " << y;
    }
  }
}

TEST(Blur, StandsKernelsThatAreWiderThanTheImage) {
  const OwnedPlane in = noise(5, 1);
  const OwnedPlane out = image(5, 1);
  const auto scratch = std::make_unique<BlurRow>();
  blur(in.plane, gaussian_kernel(3.0), scratch.get(), out.plane);
  const auto [least, most] = std::minmax_element(in.memory.begin(), in.memory.begin() + 5);
  for (int x = 0; x < 5; ++x) {
    EXPECT_GE(out.plane.row(0)[x], *least - 1e-3F);
    EXPECT_LE(out.plane.row(0)[x], *most + 1e-3F);
  }
}

TEST(WorkingSize, KeepsToTheLimits) {
  const auto size = [](int width, int height) {
    return working_size({0, 0, width, height}, 260000, 2.0);
  };
  EXPECT_EQ(size(100, 80).width, 200);
  EXPECT_EQ(size(100, 80).height, 160);
  for (const auto& [width, height] :
       {std::pair{1920, 1080}, {8192, 8192}, {8192, 16}, {16, 8192}, {511, 509}}) {
    const WorkingSize s = size(width, height);
    EXPECT_LE(s.width * s.height, 260000);
    EXPECT_LE(std::max(s.width, s.height), static_cast<int>(limits::kWorkingSide));
    EXPECT_GE(std::min(s.width, s.height), 1);
    EXPECT_DOUBLE_EQ(s.factor_u * width, s.width);
    EXPECT_DOUBLE_EQ(s.factor_v * height, s.height);
  }
}

/// A ramp stays the same ramp in the middle, and does not leave its range at the border.
TEST(Resample, KeepsPlaces_WhenItEnlarges_AndWhenItReduces) {
  cv::Mat gray(96, 120, CV_8UC1);
  for (int v = 0; v < gray.rows; ++v) {
    for (int u = 0; u < gray.cols; ++u) {
      gray.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(u + v);
    }
  }
  const cv::Rect region(7, 5, 101, 83);
  const auto scratch = std::make_unique<ResampleScratch>();
  for (const int pixels_max : {700, 2200, 8383, 12000, 400000}) {
    SCOPED_TRACE(pixels_max);
    const WorkingSize size = working_size(region, pixels_max, 2.0);
    const OwnedPlane out = image(size.width, size.height);
    resample(gray, region, light_of_gray(1.0), scratch.get(), out.plane);
    // Three output pixels from the border nothing of the outside is left. In a mean over an area a
    // pixel that is partly covered counts with its centre, up to 1/4 pixel from the covered part's,
    // over up to half a pixel at either end; cubic convolution is exact on a ramp.
    const double tolerance = size.factor_u < 1.0 ? 0.25 * size.factor_u : 1e-3;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const double u_px = (x + 0.5) / size.factor_u - 0.5 + region.x;
        const double v_px = (y + 0.5) / size.factor_v - 0.5 + region.y;
        const bool inside = std::min(x, y) >= 3 && x < size.width - 3 && y < size.height - 3;
        ASSERT_NEAR(
            static_cast<double>(out.plane.row(y)[x]), u_px + v_px, inside ? tolerance : 1.0);
      }
    }
  }
}

TEST(LightOfGray, UndoesTheCameraThatCodedIt) {
  for (const double gamma : {1.0, 1.8, 2.2}) {
    SCOPED_TRACE(gamma);
    const Tone light = light_of_gray(gamma);
    EXPECT_EQ(light.front(), 0.0F);
    EXPECT_FLOAT_EQ(light.back(), 255.0F);
    EXPECT_TRUE(std::is_sorted(light.begin(), light.end()));
    for (const double seen : {20.0, 90.0, 200.0}) {
      const double gray = 255.0 * std::pow(seen / 255.0, 1.0 / gamma);
      // A gray level is rounded by a half, and its light by gamma times its share of that.
      const double step = gamma * 0.5 / gray * seen;
      EXPECT_NEAR(static_cast<double>(light[static_cast<std::size_t>(std::lround(gray))]),
                  seen,
                  1.1 * step);
    }
  }
}

TEST(Resample, GivesBackTheImage_AtItsOwnSize) {
  Rng rng(32, 0);
  cv::Mat gray(40, 50, CV_8UC1);
  for (int v = 0; v < gray.rows; ++v) {
    for (int u = 0; u < gray.cols; ++u) {
      gray.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(rng.below(256));
    }
  }
  const cv::Rect all(0, 0, 50, 40);
  const WorkingSize size = working_size(all, 2000, 2.0);
  ASSERT_EQ(size.width, 50);
  const OwnedPlane out = image(50, 40);
  const auto scratch = std::make_unique<ResampleScratch>();
  resample(gray, all, light_of_gray(1.0), scratch.get(), out.plane);
  for (int v = 0; v < 40; ++v) {
    for (int u = 0; u < 50; ++u) {
      EXPECT_NEAR(static_cast<double>(out.plane.row(v)[u]), gray.at<std::uint8_t>(v, u), 1e-4);
    }
  }
}

TEST(ScaleSpace, BlursAGaussianToTheHeightThatTheoryGives) {
  constexpr double kBlob_px = 6.0;
  constexpr double kInput_px = 0.5;
  constexpr int kMiddle = 64;
  const auto space = std::make_unique<ScaleSpace>();
  const Plane in = lay_out_scale_space(129, 129, space.get());
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      const double r2 = std::pow(x - kMiddle, 2) + std::pow(y - kMiddle, 2);
      in.row(y)[x] = static_cast<float>(100.0 * std::exp(-0.5 * r2 / (kBlob_px * kBlob_px)));
    }
  }
  fill_scale_space(kInput_px, space.get());
  ASSERT_GE(space->octaves, 3);
  for (int o = 0; o < 3; ++o) {
    for (std::size_t l = 0; l < ScaleSpace::kLevels; ++l) {
      const Plane& level = space->level[static_cast<std::size_t>(o)][l];
      const double sigma_px = (1 << o) * static_cast<double>(sigma_of_level(static_cast<float>(l)));
      const double added2 = sigma_px * sigma_px - kInput_px * kInput_px;
      const double expected = 100.0 * kBlob_px * kBlob_px / (kBlob_px * kBlob_px + added2);
      // The cut kernels fall short of their variance by up to 3 %.
      EXPECT_NEAR(
          static_cast<double>(level.row(kMiddle >> o)[kMiddle >> o]), expected, 0.02 * expected)
          << "octave " << o << " level " << l;
    }
  }
}

TEST(ScaleSpace, FitsIntoItsMemory_AtTheLimits) {
  const auto space = std::make_unique<ScaleSpace>();
  const int side = static_cast<int>(limits::kWorkingSide);
  const int other = static_cast<int>(limits::kWorkingPixels) / side;
  for (const auto& [width, height] :
       {std::pair{side, other}, {other, side}, {721, 721}, {16, 16}}) {
    const Plane in = lay_out_scale_space(width, height, space.get());
    EXPECT_EQ(in.width, width);
    EXPECT_EQ(in.height, height);
    EXPECT_GE(space->octaves, 1);
  }
  EXPECT_EQ(lay_out_scale_space(200, 15, space.get()).data, nullptr);
  EXPECT_EQ(space->octaves, 0);
}

}  // namespace
}  // namespace polhode::sift::scale_space_test
