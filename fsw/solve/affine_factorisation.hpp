// Shape and motion of a small distant body from tracks observed in every frame (weak perspective).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"

namespace polhode {

/// Images of N tracks in each of F frames: row f is x and row F + f is y of frame f, a column per
/// track; normalised units. Each frame is rotated so that the tracks' centre lies near the
/// optical axis.
using ImageMatrix = Eigen::MatrixXd;

/// x = scale_f * (first two rows of R_f) * p_T + centroid of the frame.
struct WeakPerspectiveMotion {
  FixedVector<Eigen::Matrix3d, limits::kInitialFrames> R_CT;
  FixedVector<double, limits::kInitialFrames> scale;
};

/// Three-dimensional subspace that the tracks' images span, robust to wrong tracks.
struct AffineSubspace {
  Eigen::Matrix<double, Eigen::Dynamic, 3> axes;  ///< 2 F rows, orthonormal columns
  Eigen::Vector4d singular_values =
      Eigen::Vector4d::Zero();  ///< of the inliers' images, divided by sqrt(N)
  FixedVector<std::uint8_t, limits::kInitialTracks> inlier;  ///< by column
  int inliers = 0;
  bool valid = false;
};

/// Consensus over samples of five tracks by the median residual. Then three rounds of least squares
/// on the tracks within three robust standard deviations. Tolerates 35 % of wrong tracks.
/// @param images            F >= 3, N >= 8.
/// @param sigma_normalised  1-sigma of a coordinate: the least tolerance.
/// @source Tomasi and Kanade, IJCV 1992; median: Rousseeuw 1984.
AffineSubspace find_affine_subspace(const ImageMatrix& images,
                                    double sigma_normalised,
                                    std::uint64_t seed);

/// Upgrade from affine to metric: rotations and scales for which the subspace is that of a rigid
/// body, by the linear equations for Q = A A^T in |m1| = |m2|, m1.m2 = 0, regularised towards a
/// body as deep as wide.
/// @param isotropy  weight of that regularisation per frame: 0 none; 0.01 weak; 0.3 strong.
/// @return false when Q has no positive part in two of its directions.
/// @source Poelman and Kanade, PAMI 1997 (scaled orthography).
bool upgrade_to_metric(const AffineSubspace& subspace,
                       double isotropy,
                       WeakPerspectiveMotion* motion);

/// Least-squares points for the motion; columns of `images` are taken relative to their frame's
/// mean over the inliers.
/// @return 3 x N, for inliers and outliers alike.
Eigen::Matrix3Xd weak_perspective_points(const ImageMatrix& images,
                                         std::span<const std::uint8_t> inlier,
                                         const WeakPerspectiveMotion& motion);

/// Columns less the inliers' mean.
ImageMatrix centred(const ImageMatrix& images, std::span<const std::uint8_t> inlier);

}  // namespace polhode
