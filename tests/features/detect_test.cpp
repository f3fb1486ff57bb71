#include "features/detect.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/rng.hpp"
#include "features/match.hpp"
#include "features/workspace.hpp"

namespace polhode::detect_test {
namespace {

struct Blob {
  double u_px = 0.0;
  double v_px = 0.0;
  double sigma_px = 3.0;
  double height = 120.0;
};

CameraModel camera_for(const cv::Mat& gray) {
  return {.width_px = gray.cols,
          .height_px = gray.rows,
          .fu_px = 800.0,
          .fv_px = 810.0,
          .cu_px = 0.5 * gray.cols,
          .cv_px = 0.5 * gray.rows};
}

/// Gaussian blobs sampled at pixel centres, which have integer coordinates.
cv::Mat draw(int width, int height, double background, const std::vector<Blob>& blobs) {
  cv::Mat sum(height, width, CV_64FC1);
  sum.setTo(background);
  for (const Blob& blob : blobs) {
    const int reach = static_cast<int>(5.0 * blob.sigma_px) + 1;
    for (int v = std::max(0, static_cast<int>(blob.v_px) - reach);
         v <= std::min(height - 1, static_cast<int>(blob.v_px) + reach);
         ++v) {
      for (int u = std::max(0, static_cast<int>(blob.u_px) - reach);
           u <= std::min(width - 1, static_cast<int>(blob.u_px) + reach);
           ++u) {
        const double r2 = std::pow(u - blob.u_px, 2) + std::pow(v - blob.v_px, 2);
        sum.at<double>(v, u) += blob.height * std::exp(-0.5 * r2 / (blob.sigma_px * blob.sigma_px));
      }
    }
  }
  cv::Mat gray;
  sum.convertTo(gray, CV_8UC1);
  return gray;
}

/// For images that are drawn in light.
constexpr FeatureOptions kLinear{.gamma = 1.0};

TargetMask whole(const cv::Mat& gray) {
  TargetMask mask;
  find_target(gray, {.enabled = false}, &mask);
  return mask;
}

std::unique_ptr<Features> detect(const cv::Mat& gray,
                                 const TargetMask& mask,
                                 const FeatureOptions& options = kLinear) {
  auto features = std::make_unique<Features>();
  const auto workspace = std::make_unique<FeatureWorkspace>();
  detect_features({&gray, &mask}, camera_for(gray), options, workspace.get(), features.get());
  return features;
}

double nearest_px(const Features& features, double u_px, double v_px, Eigen::Vector2d* offset) {
  double best = 1e9;
  for (const Feature& f : features) {
    const Eigen::Vector2d d(static_cast<double>(f.u_px) - u_px, static_cast<double>(f.v_px) - v_px);
    if (d.norm() < best) {
      best = d.norm();
      *offset = d;
    }
  }
  return best;
}

/// Blobs on a grid, each at its own phase of the pixel.
std::vector<Blob> blob_grid(int width, int height, double pitch_px, double sigma_px, Rng* rng) {
  std::vector<Blob> blobs;
  for (double v = pitch_px; v < height - pitch_px; v += pitch_px) {
    for (double u = pitch_px; u < width - pitch_px; u += pitch_px) {
      blobs.push_back(
          {.u_px = u + rng->uniform(), .v_px = v + rng->uniform(), .sigma_px = sigma_px});
    }
  }
  return blobs;
}

/// Nearly all blobs are found (a perfectly round one whose size falls between two octaves may be
/// refused by the detector's interpolation), each within `tolerance_px`; the mean offset, where a
/// wrong pixel convention would show, within a third.
void expect_found(const cv::Mat& gray,
                  const TargetMask& mask,
                  const FeatureOptions& options,
                  const std::vector<Blob>& blobs,
                  double tolerance_px) {
  const auto features = detect(gray, mask, options);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int found = 0;
  for (const Blob& blob : blobs) {
    Eigen::Vector2d offset = Eigen::Vector2d::Zero();
    const double off_px = nearest_px(*features, blob.u_px, blob.v_px, &offset);
    if (off_px < 2.0) {
      EXPECT_LT(off_px, tolerance_px) << blob.u_px << ", " << blob.v_px;
      sum += offset;
      ++found;
    }
  }
  ASSERT_GE(found, static_cast<int>(8 * blobs.size() / 10));
  EXPECT_LT((sum / found).norm(), tolerance_px / 3.0);
}

/// What a camera that answers light with its power 1 / gamma makes of a linear one's image.
cv::Mat coded(const cv::Mat& light, double gamma) {
  cv::Mat table(1, 256, CV_8UC1);
  for (int level = 0; level < 256; ++level) {
    table.at<std::uint8_t>(level) =
        static_cast<std::uint8_t>(std::lround(255.0 * std::pow(level / 255.0, 1.0 / gamma)));
  }
  cv::Mat gray;
  cv::LUT(light, table, gray);
  return gray;
}

/// Largest distance of a lone blob's feature from its place, over phases of the pixel; the blob
/// stands on the flank of a wide one, as on a shaded side.
double worst_shift_px(double camera_gamma, double gamma) {
  double worst = 0.0;
  for (const double phase : {0.0, 0.3, 0.6}) {
    const Blob spot{.u_px = 80.0 + phase, .v_px = 60.0 + phase, .sigma_px = 3.0, .height = 60.0};
    const Blob shade{.u_px = 110.0, .v_px = 60.0, .sigma_px = 25.0, .height = 130.0};
    const cv::Mat light = draw(160, 120, 8.0, {spot, shade});
    Eigen::Vector2d off = Eigen::Vector2d::Zero();
    const auto features =
        detect(coded(light, camera_gamma), whole(light), {.gamma = gamma, .contrast_min = 0.01});
    worst = std::max(worst, nearest_px(*features, spot.u_px, spot.v_px, &off));
  }
  return worst;
}

/// Light adds up, gray levels of a camera that bends it do not: on a shaded side they displace a
/// spot, and all spots of the side alike.
TEST(DetectFeatures, PlacesSpotsOnAShadedSideByTheirLight) {
  const double linear_px = worst_shift_px(1.0, 1.0);
  EXPECT_NEAR(worst_shift_px(2.2, 2.2), linear_px, 0.05);
  EXPECT_GT(worst_shift_px(2.2, 1.0), linear_px + 0.1);
}

// verifies: FEA-01
TEST(DetectFeatures, FindsBlobsAtTheirPlace_ForEachSizeOfBlob) {
  for (const double sigma_px : {2.0, 3.0, 5.0}) {
    SCOPED_TRACE(sigma_px);
    Rng rng(21, 0);
    // Round blobs come with several orientations each: few enough blobs that all fit into the
    // table.
    const std::vector<Blob> blobs =
        blob_grid(320, 240, std::max(40.0, 12.0 * sigma_px), sigma_px, &rng);
    const cv::Mat gray = draw(320, 240, 30.0, blobs);
    // Quantisation to 256 levels of a blob 120 high moves its peak by some hundredths of a pixel.
    expect_found(gray, whole(gray), {.count_max = 1000, .gamma = 1.0}, blobs, 0.1);
  }
}

TEST(DetectFeatures, FindsBlobsAtTheirPlace_WhenTheRegionIsAPartOfTheImage) {
  Rng rng(22, 0);
  cv::Mat gray = draw(400, 300, 0.0, {});
  const cv::Rect body(101, 67, 203, 151);
  std::vector<Blob> blobs = blob_grid(body.width, body.height, 40.0, 3.0, &rng);
  for (Blob& blob : blobs) {
    blob.u_px += body.x;
    blob.v_px += body.y;
  }
  draw(400, 300, 60.0, blobs)(body).copyTo(gray(body));
  TargetMask mask;
  find_target(gray, {}, &mask);
  ASSERT_LT(mask.region_px.width, 240) << "the region has to be a part";
  expect_found(gray, mask, {.count_max = 1000, .gamma = 1.0}, blobs, 0.1);
}

TEST(DetectFeatures, FindsBlobsAtTheirPlace_WhenTheRegionIsReduced) {
  Rng rng(23, 0);
  const std::vector<Blob> blobs = blob_grid(643, 481, 72.0, 6.0, &rng);
  const cv::Mat gray = draw(643, 481, 30.0, blobs);
  // 643 x 481 to 80 000 pixels is a factor of 1.97: a tenth of a reduced pixel is 0.2 px.
  expect_found(gray,
               whole(gray),
               {.count_max = 1000, .gamma = 1.0, .working_pixels_max = 80000},
               blobs,
               0.2);
}

TEST(DetectFeatures, GivesTheUndistortedPointOfEachPixel) {
  Rng rng(24, 0);
  const cv::Mat gray = draw(320, 240, 30.0, blob_grid(320, 240, 30.0, 3.0, &rng));
  CameraModel camera = camera_for(gray);
  camera.k1 = -0.2;
  camera.p1 = 1e-3;
  auto features = std::make_unique<Features>();
  const auto workspace = std::make_unique<FeatureWorkspace>();
  const TargetMask mask = whole(gray);
  detect_features({&gray, &mask}, camera, {}, workspace.get(), features.get());
  ASSERT_FALSE(features->empty());
  for (const Feature& f : *features) {
    const Eigen::Vector2d back = project_px(camera, f.normalised);
    // Pixels are stored in single precision: half a unit in the last place is 1.5e-5 px at 256 px
    // and over.
    EXPECT_NEAR(back.x(), static_cast<double>(f.u_px), 2e-5);
    EXPECT_NEAR(back.y(), static_cast<double>(f.v_px), 2e-5);
    EXPECT_GT(f.sigma_px, 0.0F);
    EXPECT_GT(f.scale_px, 0.0F);
  }
}

TEST(DetectFeatures, GivesLargerBlobsALargerScale_InProportion) {
  // A blob of sigma s answers most at the scale s: the measured radii have the ratio of the sigmas,
  // within half the step of the scale space (2^(1/6) with three layers an octave).
  double radius[2] = {0.0, 0.0};
  const double sigma[2] = {2.5, 5.0};
  for (int i = 0; i < 2; ++i) {
    const cv::Mat gray = draw(160, 160, 30.0, {{.u_px = 80.3, .v_px = 79.6, .sigma_px = sigma[i]}});
    double best = 1e9;
    const auto features = detect(gray, whole(gray));
    for (const Feature& f : *features) {
      const double off =
          std::hypot(static_cast<double>(f.u_px) - 80.3, static_cast<double>(f.v_px) - 79.6);
      if (off < best) {
        best = off;
        radius[i] = static_cast<double>(f.scale_px);
      }
    }
    ASSERT_LT(best, 0.1);
  }
  EXPECT_NEAR(radius[1] / radius[0], 2.0, 2.0 * (std::pow(2.0, 1.0 / 6.0) - 1.0));
}

TEST(DetectFeatures, FindsNothing_OnBlack_OnUniform_AndWithoutATarget) {
  for (const double level : {0.0, 128.0, 255.0}) {
    const cv::Mat gray = draw(320, 240, level, {});
    EXPECT_TRUE(detect(gray, whole(gray))->empty()) << level;
  }
  const cv::Mat textured = draw(320, 240, 0.0, {{.u_px = 100.0, .v_px = 100.0}});
  EXPECT_TRUE(detect(textured, TargetMask{})->empty());
}

TEST(DetectFeatures, FindsNothingOutsideTheMask) {
  Rng rng(25, 0);
  const cv::Mat gray = draw(320, 240, 30.0, blob_grid(320, 240, 30.0, 3.0, &rng));
  TargetMask mask = whole(gray);
  mask.cells.colRange(0, mask.cells.cols / 2).setTo(0);
  const auto features = detect(gray, mask);
  EXPECT_FALSE(features->empty());
  for (const Feature& f : *features) {
    EXPECT_GT(f.u_px, 158.0F) << "the edge of the cells is at 160 px, placed to within a pixel";
  }
}

// verifies: FEA-04
TEST(DetectFeatures, KeepsAtMostCountMax_AndSpreadsThem) {
  // Strong blobs crowd the left quarter; the right one has weak blobs, and still gets its share.
  Rng rng(26, 0);
  std::vector<Blob> blobs;
  for (int i = 0; i < 150; ++i) {
    blobs.push_back({.u_px = 12.0 + 60.0 * rng.uniform(),
                     .v_px = 10.0 + 220.0 * rng.uniform(),
                     .sigma_px = 2.0,
                     .height = 90.0});
  }
  for (int i = 0; i < 40; ++i) {
    blobs.push_back({.u_px = 240.0 + 68.0 * rng.uniform(),
                     .v_px = 10.0 + 220.0 * rng.uniform(),
                     .sigma_px = 2.0,
                     .height = 20.0});
  }
  const cv::Mat gray = draw(320, 240, 20.0, blobs);
  const auto all = detect(gray, whole(gray), {.count_max = 1000, .gamma = 1.0});
  ASSERT_GT(all->size(), 100U);
  const auto few = detect(gray, whole(gray), {.count_max = 60, .gamma = 1.0});
  EXPECT_EQ(few->size(), 60U);
  const auto right = [](const Features& features) {
    return std::count_if(
        features.begin(), features.end(), [](const Feature& f) { return f.u_px > 230.0F; });
  };
  EXPECT_GE(right(*few), std::min<std::ptrdiff_t>(15, right(*all)))
      << "a quarter of the places for a fifth of the blobs";
}

TEST(DetectFeatures, GivesTheSameBytes_EachTime) {
  Rng rng(27, 0);
  const cv::Mat gray = draw(320, 240, 30.0, blob_grid(320, 240, 17.0, 2.5, &rng));
  const auto a = detect(gray, whole(gray));
  const auto b = detect(gray, whole(gray));
  ASSERT_EQ(a->size(), b->size());
  for (std::size_t i = 0; i < a->size(); ++i) {
    EXPECT_EQ((*a)[i].u_px, (*b)[i].u_px);
    EXPECT_EQ((*a)[i].v_px, (*b)[i].v_px);
    EXPECT_EQ((*a)[i].angle_rad, (*b)[i].angle_rad);
    EXPECT_EQ((*a)[i].descriptor, (*b)[i].descriptor);
  }
}

/// Blobs of many sizes at random places: no two neighbourhoods are alike.
cv::Mat random_texture(int side, std::uint64_t seed) {
  Rng rng(seed, 28);
  std::vector<Blob> blobs;
  for (int i = 0; i < 260; ++i) {
    blobs.push_back({.u_px = side * rng.uniform(),
                     .v_px = side * rng.uniform(),
                     .sigma_px = 2.0 + 4.0 * rng.uniform(),
                     .height = 70.0 * (rng.uniform() < 0.5 ? -1.0 : 1.0)});
  }
  return draw(side, side, 120.0, blobs);
}

// verifies: FEA-02
TEST(DetectFeatures, MatchesAnImageTurnedByAnyAngle) {
  constexpr int kSide = 320;
  const cv::Mat before = random_texture(kSide, 1);
  const auto a = detect(before, whole(before));
  ASSERT_GT(a->size(), 80U);
  for (const double angle_deg : {30.0, 90.0, 137.0}) {
    SCOPED_TRACE(angle_deg);
    const double middle = 0.5 * (kSide - 1);
    const double radians = angle_deg * std::numbers::pi / 180.0;
    const cv::Matx23d turn(std::cos(radians),
                           -std::sin(radians),
                           middle * (1.0 - std::cos(radians) + std::sin(radians)),
                           std::sin(radians),
                           std::cos(radians),
                           middle * (1.0 - std::sin(radians) - std::cos(radians)));
    cv::Mat after;
    cv::warpAffine(before, after, turn, before.size(), cv::INTER_CUBIC, cv::BORDER_CONSTANT, 120);
    const auto b = detect(after, whole(after));
    auto matches = std::make_unique<FeatureMatches>();
    match_mutual(a->view(), b->view(), 0.8, matches.get());
    int right = 0;
    double turned_wrong = 0.0;
    for (const FeatureMatch& m : *matches) {
      const Feature& fa = (*a)[static_cast<std::size_t>(m.a)];
      const Feature& fb = (*b)[static_cast<std::size_t>(m.b)];
      const cv::Vec2d expected = turn * cv::Vec3d(fa.u_px, fa.v_px, 1.0);
      // Clipped neighbourhoods shift the coarsest blobs by a pixel; wrong matches lie anywhere.
      if (std::hypot(expected[0] - static_cast<double>(fb.u_px),
                     expected[1] - static_cast<double>(fb.v_px)) < 1.5) {
        ++right;
        turned_wrong += std::abs(std::remainder(
            static_cast<double>(fb.angle_rad - fa.angle_rad) - radians, 2.0 * std::numbers::pi));
      }
    }
    EXPECT_GT(static_cast<int>(matches->size()), static_cast<int>(a->size()) / 3)
        << "corners of the square are lost";
    EXPECT_GE(right, 95 * static_cast<int>(matches->size()) / 100);
    // The orientation histogram has bins of 10 deg.
    EXPECT_LT(turned_wrong / right, 10.0 * std::numbers::pi / 180.0);
  }
}

}  // namespace
}  // namespace polhode::detect_test
