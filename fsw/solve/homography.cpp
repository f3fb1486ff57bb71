#include "solve/homography.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "base/assert.hpp"
#include "base/consensus.hpp"

namespace polhode {
namespace {

// Gate: chi-square of two coordinates, 99 %.
constexpr double kTransferMax2 = 9.21;
// Rounds of choosing inliers and fitting them. Chosen.
constexpr int kRounds = 3;
// Least pairs: twice the least that determine a homography.
constexpr std::size_t kPairsMin = 8;
// "HO": the random stream of this sampler.
constexpr std::uint64_t kStream = 0x484FULL;
// Avoid divisions by zero.
constexpr double kSpreadMin = 1e-30;
constexpr double kSingularMin = 1e-300;
constexpr double kDepthMin = 1e-12;

/// Similarity that moves the points' mean to 0 and their spread to 1, for conditioning.
Eigen::Matrix3d conditioner(std::span<const Eigen::Vector2d> x) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : x) {
    mean += p;
  }
  mean /= static_cast<double>(x.size());
  double spread = 0.0;
  for (const Eigen::Vector2d& p : x) {
    spread += (p - mean).squaredNorm();
  }
  const double scale = std::sqrt(static_cast<double>(x.size()) / std::max(spread, kSpreadMin));
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  T.topLeftCorner<2, 2>() *= scale;
  T.topRightCorner<2, 1>() = -scale * mean;
  return T;
}

/// Null vector of the linear equations of the pairs that `use` selects.
template <typename Use>
Eigen::Matrix3d linear_homography(std::span<const Eigen::Vector2d> x_a,
                                  std::span<const Eigen::Vector2d> x_b,
                                  const Eigen::Matrix3d& T_a,
                                  const Eigen::Matrix3d& T_b,
                                  const Use& use) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < x_a.size(); ++i) {
    if (!use(i)) {
      continue;
    }
    const Eigen::Vector3d a = T_a * x_a[i].homogeneous();
    const Eigen::Vector2d b = (T_b * x_b[i].homogeneous()).head<2>();
    Eigen::Matrix<double, 2, 9> rows = Eigen::Matrix<double, 2, 9>::Zero();
    rows.block<1, 3>(0, 0) = a.transpose();
    rows.block<1, 3>(0, 6) = -b.x() * a.transpose();
    rows.block<1, 3>(1, 3) = a.transpose();
    rows.block<1, 3>(1, 6) = -b.y() * a.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::JacobiSVD<Eigen::Matrix<double, 9, 9>> svd(normal, Eigen::ComputeFullV);
  const Eigen::Matrix<double, 9, 1> h = svd.matrixV().col(8);
  Eigen::Matrix3d H;
  H << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  return T_b.inverse() * H * T_a;
}

double transfer2(const Eigen::Matrix3d& H, const Eigen::Vector2d& x_a, const Eigen::Vector2d& x_b) {
  const Eigen::Vector3d y = H * x_a.homogeneous();
  return std::abs(y.z()) > kDepthMin ? (y.hnormalized() - x_b).squaredNorm() : kNoScore;
}

struct Hypothesis {
  Eigen::Matrix3d H_ba = Eigen::Matrix3d::Identity();
  int inliers = 0;
};

/// Truncated sum of squares, and the inliers.
double score_of(std::span<const Eigen::Vector2d> x_a,
                std::span<const Eigen::Vector2d> x_b,
                double inverse_variance,
                Hypothesis* h) {
  double sum = 0.0;
  h->inliers = 0;
  for (std::size_t i = 0; i < x_a.size(); ++i) {
    const double e2 = transfer2(h->H_ba, x_a[i], x_b[i]) * inverse_variance;
    sum += std::min(e2, kTransferMax2);
    h->inliers += e2 < kTransferMax2 ? 1 : 0;
  }
  return sum;
}

/// Scales H so that its middle singular value is 1, with the sign of positive depths.
Eigen::Matrix3d euclidean(const Eigen::Matrix3d& H, const Eigen::Vector2d& x_a) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H);
  const double sign = (H * x_a.homogeneous()).z() < 0.0 ? -1.0 : 1.0;
  return sign * H / std::max(svd.singularValues()(1), kSingularMin);
}

bool in_front(const PanelMotion& m, std::span<const Eigen::Vector2d> x_a) {
  std::size_t count = 0;
  for (const Eigen::Vector2d& x : x_a) {
    count += m.normal_a.dot(x.homogeneous()) > 0.0 ? 1U : 0U;
  }
  return 10 * count >= 8 * x_a.size();  // four in five: some pairs are outliers
}

void decompose(std::span<const Eigen::Vector2d> x_a, HomographyFit* fit) {
  cv::Matx33d H;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      H(r, c) = fit->H_ba(r, c);
    }
  }
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  std::vector<cv::Mat> normals;
  const int count =
      cv::decomposeHomographyMat(H, cv::Matx33d::eye(), rotations, translations, normals);
  for (int k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    PanelMotion m;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        m.motion.R_ba(r, c) = rotations[i].at<double>(r, c);
      }
      m.motion.p_ba(r) = translations[i].at<double>(r);
      m.normal_a(r) = normals[i].at<double>(r);
    }
    if (in_front(m, x_a) && m.motion.R_ba.allFinite() && m.motion.p_ba.allFinite()) {
      (void)fit->motions.push_back(m);
    }
  }
}

}  // namespace

HomographyFit find_homography(std::span<const Eigen::Vector2d> x_a,
                              std::span<const Eigen::Vector2d> x_b,
                              const TwoViewOptions& options) {
  POLHODE_ASSERT(x_a.size() == x_b.size(), x_a.size());
  HomographyFit fit;
  fit.score = kNoScore;
  if (x_a.size() < kPairsMin) {
    return fit;
  }
  const Eigen::Matrix3d T_a = conditioner(x_a);
  const Eigen::Matrix3d T_b = conditioner(x_b);
  // The error has the noise of two images.
  const double inverse_variance = 0.5 / (options.sigma_normalised * options.sigma_normalised);
  const auto score = [&](Hypothesis* h, double) {
    return h->H_ba.allFinite() ? score_of(x_a, x_b, inverse_variance, h) : kNoScore;
  };
  BestHypothesis<Hypothesis> best;
  find_consensus<4>(
      {.points = x_a.size(), .draws_max = options.samples, .seed = options.seed, .stream = kStream},
      [&](const Sample<4>& sample) {
        const auto drawn = [&](std::size_t i) {
          return std::find(sample.begin(), sample.end(), i) != sample.end();
        };
        return std::optional<Hypothesis>({.H_ba = linear_homography(x_a, x_b, T_a, T_b, drawn)});
      },
      score,
      &best);
  for (int round = 0; round < kRounds; ++round) {
    const auto inlier = [&, H = best.model.H_ba](std::size_t i) {
      return transfer2(H, x_a[i], x_b[i]) * inverse_variance < kTransferMax2;
    };
    consider(Hypothesis{.H_ba = linear_homography(x_a, x_b, T_a, T_b, inlier)}, score, &best);
  }
  fit.H_ba = euclidean(best.model.H_ba, x_a[0]);
  fit.score = best.score;
  fit.inliers = best.model.inliers;
  decompose(x_a, &fit);
  return fit;
}

}  // namespace polhode
