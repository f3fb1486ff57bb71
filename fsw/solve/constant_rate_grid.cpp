#include "solve/constant_rate_grid.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/assert.hpp"
#include "geometry/so3.hpp"
#include "solve/small_fit.hpp"

namespace polhode {
namespace {

// Rotation (wx, wy, wz) T in rad and change of scale over the interval T.
using Motion4 = Eigen::Vector4d;
// Combinations of tracks that are kept. A rigid body's images have rank three; the others contain
// the residuals of a motion. Chosen.
constexpr Eigen::Index kColumns = 6;
using Images = Eigen::Matrix<double, Eigen::Dynamic, kColumns>;
using Jacobian = Eigen::
    Matrix<double, Eigen::Dynamic, 4, 0, 2 * static_cast<int>(limits::kInitialFrames* kColumns), 4>;
using Model =
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 2 * static_cast<int>(limits::kInitialFrames), 3>;

// Axes in the image plane, 15 deg apart: one is within 8 deg of each minimum.
constexpr int kAzimuths = 12;
// Rotations about an in-plane axis over the interval, deg: a factor of about 1.6 apart, from the
// onset of depth to a third of a turn.
constexpr std::array<double, 7> kRotations_deg = {6.0, 10.0, 16.0, 26.0, 42.0, 68.0, 110.0};
// Steps from each grid point. Chosen; the adjustment of the hypotheses goes on from there.
constexpr int kSteps = 8;
// First damping. Chosen: a grid point is up to 8 deg and a third of the rotation off.
constexpr double kDampingFirst = 1e-2;
// Norm under which a model column depends on the others: columns without depth are rounding.
constexpr double kNormMin = 1e-6;
// Two motions within a tenth of their in-plane rotation, or of 3 deg, are one minimum.
constexpr double kSame = 0.1;
constexpr double kSameFrom_rad = 0.05;
// Least image scale: a wrong rate cannot make it negative. Chosen.
constexpr double kScaleMin = 0.1;

/// Interval-relative times in [-0.5, 0.5].
Eigen::VectorXd relative_times(std::span<const double> times_s) {
  Eigen::VectorXd t(static_cast<Eigen::Index>(times_s.size()));
  const double length = times_s.back() - times_s.front();
  for (Eigen::Index i = 0; i < t.size(); ++i) {
    t(i) = (times_s[static_cast<std::size_t>(i)] - times_s.front()) / length - 0.5;
  }
  return t;
}

Model model_axes(const Motion4& motion, const Eigen::VectorXd& t) {
  const Eigen::Index frames = t.size();
  Model M(2 * frames, 3);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const Eigen::Matrix3d R = so3_exp(motion.head<3>() * t(f));
    const double scale = 1.0 + motion(3) * t(f);
    M.row(f) = scale * R.row(0);
    M.row(frames + f) = scale * R.row(1);
  }
  return M;
}

/// Residual of the best shape for this motion.
Images residual(const Motion4& motion, const Images& images, const Eigen::VectorXd& t) {
  Model Q = model_axes(motion, t);
  // Gram-Schmidt; a column that depends on the others (no rotation: no depth) drops out.
  for (Eigen::Index c = 0; c < 3; ++c) {
    for (Eigen::Index k = 0; k < c; ++k) {
      Q.col(c) -= Q.col(k).dot(Q.col(c)) * Q.col(k);
    }
    const double norm = Q.col(c).norm();
    Q.col(c) *= norm > kNormMin ? 1.0 / norm : 0.0;
  }
  return images - Q * (Q.transpose() * images);
}

struct Minimum {
  Motion4 motion;
  double residual2;
};

/// Derivatives by forward differences.
bool linearise(const Motion4& motion,
               const Images& images,
               const Eigen::VectorXd& t,
               SmallEquations<4>* at) {
  constexpr double kStep = 1e-4;  // linear to 1e-4, and far above rounding
  const Images r = residual(motion, images, t);
  Jacobian J(r.size(), 4);
  for (Eigen::Index k = 0; k < 4; ++k) {
    Motion4 moved = motion;
    moved(k) += kStep;
    J.col(k) = (residual(moved, images, t) - r).reshaped() / kStep;
  }
  at->H = J.transpose() * J;
  at->g = J.transpose() * r.reshaped();
  at->cost = r.squaredNorm();
  return true;
}

Minimum descend(Motion4 motion, const Images& images, const Eigen::VectorXd& t) {
  const auto at = [&](const Motion4& trial, SmallEquations<4>* equations) {
    return linearise(trial, images, t, equations);
  };
  SmallEquations<4> least;
  (void)minimise(at, {.steps_max = kSteps, .damping_first = kDampingFirst}, &motion, &least);
  return {motion, least.cost};
}

/// Rotation of the image about the line of sight, by the best 2-d similarity between the ends.
Motion4 image_motion(const ImageMatrix& images) {
  const Eigen::Index frames = images.rows() / 2;
  const auto x0 = images.row(0);
  const auto y0 = images.row(frames);
  const auto x1 = images.row(frames - 1);
  const auto y1 = images.row(2 * frames - 1);
  const double along = x0.dot(x1) + y0.dot(y1);
  const double across = x0.dot(y1) - y0.dot(x1);
  Motion4 motion = Motion4::Zero();
  motion(2) = std::atan2(across, along);
  return motion;
}

/// The leading combinations of the tracks' images: nearly the same residuals, less work.
Images compress(const ImageMatrix& images) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(images * images.transpose());
  const Eigen::Index columns = std::min<Eigen::Index>(kColumns, images.rows());
  Images out = Images::Zero(images.rows(), kColumns);
  for (Eigen::Index k = 0; k < columns; ++k) {
    const Eigen::Index from = images.rows() - 1 - k;
    out.col(k) =
        eigen.eigenvectors().col(from) * std::sqrt(std::max(0.0, eigen.eigenvalues()(from)));
  }
  return out;
}

bool same(const Motion4& a, const Motion4& b) {
  const Motion4 depth_reversed(-b(0), -b(1), b(2), b(3));
  const double tolerance = kSame * std::max(a.head<2>().norm(), kSameFrom_rad);
  return (a - b).head<3>().norm() < tolerance || (a - depth_reversed).head<3>().norm() < tolerance;
}

}  // namespace

ConstantRateMotions search_constant_rate(const ImageMatrix& images,
                                         std::span<const double> times_s) {
  POLHODE_ASSERT(
      times_s.size() >= 3 && images.rows() == 2 * static_cast<Eigen::Index>(times_s.size()),
      images.rows());
  if (!(times_s.back() > times_s.front())) {
    return {};  // times of years and of nanoseconds in one problem
  }
  const Eigen::VectorXd t = relative_times(times_s);
  const Images compressed = compress(images);
  FixedVector<Minimum, kAzimuths * kRotations_deg.size()> minima;
  for (int a = 0; a < kAzimuths; ++a) {
    // Half a circle: the other half has the depth-reversed solutions.
    const double azimuth = std::numbers::pi * (a + 0.5) / kAzimuths;
    for (const double rotation_deg : kRotations_deg) {
      const double rotation_rad = rotation_deg * std::numbers::pi / 180.0;
      Motion4 start = image_motion(images);
      start.head<2>() = rotation_rad * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
      (void)minima.push_back(descend(start, compressed, t));
    }
  }
  std::sort(minima.begin(), minima.end(), [](const Minimum& a, const Minimum& b) {
    return a.residual2 < b.residual2;
  });
  const double length = times_s.back() - times_s.front();
  ConstantRateMotions out;
  FixedVector<Motion4, kConstantRateMotions> kept;
  for (const Minimum& m : minima) {
    const bool known =
        std::any_of(kept.begin(), kept.end(), [&](const Motion4& k) { return same(k, m.motion); });
    if (known || !m.motion.allFinite() || kept.full()) {
      continue;
    }
    (void)kept.push_back(m.motion);
    (void)out.push_back({.w_C_rad_s = m.motion.head<3>() / length,
                         .scale_rate_1_s = m.motion(3) / length,
                         .residual2 = m.residual2});
  }
  return out;
}

WeakPerspectiveMotion to_motion(const ConstantRateMotion& rate, std::span<const double> times_s) {
  const double middle = 0.5 * (times_s.front() + times_s.back());
  WeakPerspectiveMotion motion;
  for (const double time : times_s) {
    const double scale = std::max(kScaleMin, 1.0 + rate.scale_rate_1_s * (time - middle));
    if (!motion.R_CT.push_back(so3_exp(rate.w_C_rad_s * (time - middle))) ||
        !motion.scale.push_back(scale)) {
      break;
    }
  }
  return motion;
}

}  // namespace polhode
