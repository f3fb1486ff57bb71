// Finds a patch of one crop again in another: affine motion, gain and offset.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "initialisation/crop.hpp"

namespace polhode {

/// A window of a crop, ready to be registered in others.
struct PatchTemplate {
  static constexpr int kHalf = 5;  ///< pixels: 11 x 11 determine a place (decision 0107)
  // Width in pixels, the middle one included.
  static constexpr int kSide = 2 * kHalf + 1;
  static constexpr std::size_t kPixels = std::size_t{kSide} * kSide;
  static constexpr int kParameters = 8;  ///< affine motion (6), gain, offset
  using Parameters = Eigen::Matrix<double, kParameters, 1>;

  std::array<Parameters, kPixels> derivatives;  ///< of a pixel's level; by the gain: the level
  Eigen::Matrix<double, kParameters, kParameters> inverse;  ///< of the weighted normal matrix
};

/// @param place  of the window's middle, in the crop's pixels.
/// @return false where the window leaves the crop, or its texture has one direction only.
bool make_template(const Crop& crop, const Eigen::Vector2d& place, PatchTemplate* patch);

struct Registration {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< of the window's middle, crop pixels
  double sigma = 0.0;  ///< 1-sigma of the place in its worse direction by the image noise, crop
                       ///< pixels
  double zncc = 0.0;   ///< correlation of the template with the crop there
};

/// Inverse-compositional Gauss-Newton: the normal matrix is constant.
/// @param affine  first guess, template to crop.
/// @param place   first guess, in the crop's pixels.
/// @return nothing where it leaves the crop or does not settle.
/// @source Baker and Matthews, IJCV 2004.
std::optional<Registration> register_patch(const PatchTemplate& patch,
                                           const Crop& crop,
                                           const Eigen::Matrix2d& affine,
                                           const Eigen::Vector2d& place);

}  // namespace polhode
