#include "features/blobs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include "base/rng.hpp"

namespace polhode::sift::blobs_test {
namespace {

/// Finds blobs in an image that is given by a formula of the place, everything being on the
/// target.
struct Found {
  std::unique_ptr<ScaleSpace> space = std::make_unique<ScaleSpace>();
  std::unique_ptr<BlobGrid> grid = std::make_unique<BlobGrid>();
  TargetMask mask;

  std::vector<Blob> all() const {
    std::vector<Blob> blobs;
    for (const BlobGrid::Cell& cell : grid->cells) {
      blobs.insert(blobs.end(), cell.begin(), cell.end());
    }
    return blobs;
  }
};

Found find(int width,
           int height,
           float contrast_min,
           const std::function<double(double, double)>& formula) {
  Found found;
  const cv::Mat gray(height, width, CV_8UC1, cv::Scalar(100));
  find_target(gray, {.enabled = false}, &found.mask);
  const Region region{.mask = &found.mask, .size = {.width = width, .height = height}};
  const Plane in = lay_out_scale_space(width, height, found.space.get());
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      in.row(y)[x] = static_cast<float>(formula(x, y));
    }
  }
  fill_scale_space(0.5, found.space.get());
  const auto rows = std::make_unique<LayerRows>();
  find_blobs(*found.space, region, contrast_min, rows.get(), found.grid.get());
  return found;
}

TEST(FindBlobs, PlacesAGaussianToAThirtiethOfAPixelOfItsOctave_BrightOrDark) {
  for (const double sign : {1.0, -1.0}) {
    for (const double sigma_px : {1.9, 2.7, 4.1, 7.0}) {
      const double u = 60.37;
      const double v = 57.81;
      const Found found = find(121, 117, 1.0F, [&](double x, double y) {
        const double r2 = std::pow(x - u, 2) + std::pow(y - v, 2);
        return 120.0 + sign * 100.0 * std::exp(-0.5 * r2 / (sigma_px * sigma_px));
      });
      const auto blobs = found.all();
      // A size between two octaves may be found from both.
      ASSERT_GE(blobs.size(), 1U) << sigma_px;
      ASSERT_LE(blobs.size(), 2U) << sigma_px;
      for (const Blob& blob : blobs) {
        const double octave = 1 << blob.octave;
        EXPECT_NEAR(static_cast<double>(blob.x) * octave, u, octave / 30.0) << sigma_px;
        EXPECT_NEAR(static_cast<double>(blob.y) * octave, v, octave / 30.0) << sigma_px;
      }
      const double scale = 1 << blobs[0].octave;
      // The difference of blurs s and s k answers most where s sqrt(k) is the blob's sigma; k =
      // 2^(1/3).
      const double answer_px =
          scale * static_cast<double>(sigma_of_level(blobs[0].level)) * std::exp2(1.0 / 6.0);
      EXPECT_NEAR(answer_px / sigma_px, 1.0, 0.1) << sigma_px;
    }
  }
}

TEST(FindBlobs, RefusesEdgesAndFaintBlobs) {
  const auto bar = [](double x, double y) {
    return 100.0 +
           60.0 * std::exp(-0.5 * (std::pow((x - 60.2) / 3.0, 2) + std::pow((y - 60.4) / 30.0, 2)));
  };
  EXPECT_TRUE(find(121, 121, 1.0F, bar).all().empty());
  const auto faint = [](double x, double y) {
    return 100.0 + 4.0 * std::exp(-0.5 * (std::pow(x - 60.2, 2) + std::pow(y - 60.4, 2)) / 9.0);
  };
  // A Gaussian's best answer is (k - 1) / (k + 1) = 0.115 of its height.
  EXPECT_EQ(find(121, 121, 0.4F, faint).all().size(), 1U);
  EXPECT_TRUE(find(121, 121, 0.55F, faint).all().empty());
}

TEST(FindBlobs, HoldsEachCellSorted_WithTheStrongestOfAFullOneLeft_AndNothingTwice) {
  // Bumps and dents 8 px apart are 250 to a cell of 90 x 90 pixels; noise makes some stronger.
  Rng rng(33, 0);
  const Found found = find(720, 720, 0.2F, [&](double x, double y) {
    constexpr double kPerPixel = 2.0 * std::numbers::pi / 8.0;
    return 120.0 + 40.0 * (std::cos(kPerPixel * x) + std::cos(kPerPixel * y)) + 5.0 * rng.uniform();
  });
  std::size_t full = 0;
  for (const BlobGrid::Cell& cell : found.grid->cells) {
    full += cell.full() ? 1U : 0U;
    for (std::size_t i = 1; i < cell.size(); ++i) {
      EXPECT_GE(cell[i - 1].contrast, cell[i].contrast);
      EXPECT_FALSE(cell[i - 1].x == cell[i].x && cell[i - 1].y == cell[i].y &&
                   cell[i - 1].octave == cell[i].octave);
    }
  }
  EXPECT_GT(full, 0U) << "the picture has to overflow some cell";
}

TEST(FindBlobs, FindsNothing_OnAPlainImage_AndInOneTooSmall) {
  EXPECT_TRUE(find(64, 64, 0.1F, [](double, double) { return 77.0; }).all().empty());
  EXPECT_TRUE(find(64, 64, 0.1F, [](double x, double y) { return 2.0 * x + y; }).all().empty());
  EXPECT_TRUE(find(8, 200, 0.1F, [](double x, double y) { return x * y; }).all().empty());
}

}  // namespace
}  // namespace polhode::sift::blobs_test
