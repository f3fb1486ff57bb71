// Own features beside OpenCV's SIFT on one pair of images: no fewer right matches, placed no
// worse; and no heap.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/rng.hpp"
#include "features/match.hpp"
#include "features/workspace.hpp"
#include "opencv_sift.hpp"

namespace {
std::atomic<long> allocations{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) {
    return memory;
  }
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace polhode::reference_test {
namespace {

constexpr int kSide = 260;

/// Noise at several scales, as a worn surface has it.
cv::Mat texture() {
  Rng rng(41, 0);
  cv::Mat sum(kSide, kSide, CV_32FC1, cv::Scalar(110.0));
  for (const double sigma_px : {1.0, 2.0, 4.0, 8.0}) {
    cv::Mat noise(kSide, kSide, CV_32FC1);
    for (int v = 0; v < kSide; ++v) {
      for (int u = 0; u < kSide; ++u) {
        noise.at<float>(v, u) = static_cast<float>(rng.uniform() - 0.5);
      }
    }
    cv::GaussianBlur(noise, noise, {}, sigma_px);
    sum += noise * (60.0 * sigma_px);
  }
  return sum;
}

/// As the camera sees it: noise of one gray level, 8 bits.
cv::Mat seen(const cv::Mat& scene, std::uint64_t seed) {
  Rng rng(seed, 0);
  cv::Mat gray(scene.size(), CV_8UC1);
  for (int v = 0; v < scene.rows; ++v) {
    for (int u = 0; u < scene.cols; ++u) {
      const double noise = rng.uniform() + rng.uniform() + rng.uniform() + rng.uniform() - 2.0;
      gray.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(static_cast<double>(scene.at<float>(v, u)) + 1.7 * noise);
    }
  }
  return gray;
}

struct Quality {
  int right = 0;
  int matches = 0;
  double median_px = 0.0;
};

template <typename Detect>
Quality judge(const cv::Mat& before,
              const cv::Mat& after,
              const cv::Matx23d& map,
              const Detect& detect) {
  const auto a = std::make_unique<Features>();
  const auto b = std::make_unique<Features>();
  detect(before, a.get());
  detect(after, b.get());
  const auto matches = std::make_unique<FeatureMatches>();
  match_mutual(a->view(), b->view(), 0.8, matches.get());
  std::vector<double> off_px;
  for (const FeatureMatch& m : *matches) {
    const Feature& fa = (*a)[static_cast<std::size_t>(m.a)];
    const Feature& fb = (*b)[static_cast<std::size_t>(m.b)];
    const cv::Vec2d expected = map * cv::Vec3d(fa.u_px, fa.v_px, 1.0);
    const double off = std::hypot(expected[0] - static_cast<double>(fb.u_px),
                                  expected[1] - static_cast<double>(fb.v_px));
    if (off < 1.5) {
      off_px.push_back(off);
    }
  }
  std::sort(off_px.begin(), off_px.end());
  return {.right = static_cast<int>(off_px.size()),
          .matches = static_cast<int>(matches->size()),
          .median_px = off_px.empty() ? 9.0 : off_px[off_px.size() / 2]};
}

// verifies: FEA-03
TEST(DetectFeatures, IsNoWorseThanOpenCvs) {
  const cv::Mat scene = texture();
  // Seen 25 deg from the side, turned by 40 deg and a little nearer.
  const cv::Matx23d map(0.78, -0.68, 126.0, 0.61, 0.76, -46.0);
  cv::Mat turned;
  cv::warpAffine(scene, turned, map, scene.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
  const cv::Mat before = seen(scene, 1);
  const cv::Mat after = seen(turned, 2);
  TargetMask mask;
  find_target(before, {.enabled = false}, &mask);
  const CameraModel camera{.width_px = kSide,
                           .height_px = kSide,
                           .fu_px = 800.0,
                           .fv_px = 800.0,
                           .cu_px = 130.0,
                           .cv_px = 130.0};
  const auto workspace = std::make_unique<FeatureWorkspace>();
  const Quality own = judge(before, after, map, [&](const cv::Mat& gray, Features* features) {
    const long before_call = allocations;
    detect_features({&gray, &mask}, camera, {}, workspace.get(), features);
    EXPECT_EQ(allocations, before_call) << "detection takes no heap";
  });
  const Quality reference = judge(before, after, map, [&](const cv::Mat& gray, Features* features) {
    benchmark::detect_features_opencv(gray, mask, camera, {}, features);
  });
  ASSERT_GT(reference.right, 50);
  EXPECT_GE(own.right, 9 * reference.right / 10)
      << "of " << own.matches << " and " << reference.matches;
  EXPECT_GE(own.right * reference.matches, 0.95 * reference.right * own.matches);
  EXPECT_LE(own.median_px, 1.15 * reference.median_px);
  RecordProperty("own_right", own.right);
  RecordProperty("opencv_right", reference.right);
}

}  // namespace
}  // namespace polhode::reference_test
