#include "solve/camera_adjustment.hpp"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <numeric>
#include <vector>

#include "solve/bundle_costs.hpp"
#include "solve/bundle_part.hpp"
#include "solve/ceres_solver.hpp"

namespace polhode {
namespace {

// Groups of Ceres's elimination order. Within a group it goes by address, which depends on the
// allocator: blocks in separately allocated memory get a group of their own.
enum Group { kPoints, kPoses, kCamera };
constexpr int kNumbers = static_cast<int>(kDeviations);
using ByDeviations = Eigen::Matrix<double, 2, kNumbers, Eigen::RowMajor>;

/// Derivative of an observation's image point by time, per s.
Eigen::Vector2d flow_of(const InverseDepthPose& pose,
                        const Eigen::Vector3d& p_T,
                        const PoseMotion& motion) {
  Eigen::Vector2d x;
  ReprojectionJacobians by;
  if (!reproject(pose, p_T, &x, &by)) {
    return Eigen::Vector2d::Zero();
  }
  return by.rotation * motion.rates.head<3>() + by.uvs * motion.rates.tail<3>();
}

ImageRates rates_of(std::span<const PoseMotion> motions) {
  ImageRates squares;
  for (const PoseMotion& motion : motions) {
    squares.turn_rad_s += motion.rates.head<3>().squaredNorm();
    squares.shift_s += motion.rates.segment<2>(3).squaredNorm();
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, motions.size()));
  return {std::sqrt(squares.turn_rad_s / count), std::sqrt(squares.shift_s / count)};
}

/// As ReprojectionCost, for a camera with deviations: by (pose, p_T, deviations). With x the
/// projection, x' its rate, and f, z, a, c, r, h the deviations in their order, the image is
/// diag(e^(f + z phase - a/2), e^(f + z phase + a/2)) (x + x' (r row + h side)) + c, row from about
/// -0.5 to 0.5 over the rows, side -0.5 in the upper half and 0.5 in the lower.
class DeviatingCost final : public ceres::SizedCostFunction<2, kPoseNumbers, 3, kNumbers> {
 public:
  /// @param flow  of the image point, taken as constant
  DeviatingCost(const BundleObservation& o,
                const ChartedPose& pose,
                const Eigen::Vector2d& flow,
                double phase,
                const CameraProblem& whole)
      : projection_({.pose = o.pose,
                     .point = o.point,
                     .normalised = Eigen::Vector2d::Zero(),
                     .sigma_normalised = o.sigma_normalised},
                    pose),
        measured_(o.normalised / o.sigma_normalised),
        inverse_sigma_(1.0 / o.sigma_normalised),
        phase_(phase),
        by_readout_(flow * (o.normalised.y() / whole.height_normalised) / o.sigma_normalised),
        by_half_(flow * (o.normalised.y() < whole.middle_normalised ? -0.5 : 0.5) /
                 o.sigma_normalised) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    if (!projection_.Evaluate(parameters, residuals, jacobians)) {
      return false;
    }
    const double* d = parameters[2];
    const double log_focal = d[0] + phase_ * d[1];
    const Eigen::Vector2d scale(std::exp(log_focal - 0.5 * d[2]), std::exp(log_focal + 0.5 * d[2]));
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    const Eigen::Vector2d at_row = residual + d[5] * by_readout_ + d[6] * by_half_;
    const Eigen::Vector2d image = scale.cwiseProduct(at_row);
    residual = image + inverse_sigma_ * Eigen::Vector2d(d[3], d[4]) - measured_;
    if (jacobians != nullptr) {
      scale_rows(jacobians[0], kPoseNumbers, scale);
      scale_rows(jacobians[1], 3, scale);
      if (jacobians[2] != nullptr) {
        Eigen::Map<ByDeviations> by(jacobians[2]);
        by << image, phase_ * image, Eigen::Vector2d(-0.5 * image.x(), 0.5 * image.y()),
            inverse_sigma_ * Eigen::Matrix2d::Identity(), scale.cwiseProduct(by_readout_),
            scale.cwiseProduct(by_half_);
      }
    }
    return true;
  }

 private:
  static void scale_rows(double* jacobian, int columns, const Eigen::Vector2d& scale) {
    if (jacobian != nullptr) {
      Eigen::Map<Eigen::VectorXd>(jacobian, columns) *= scale.x();
      Eigen::Map<Eigen::VectorXd>(jacobian + columns, columns) *= scale.y();
    }
  }
  ReprojectionCost projection_;  ///< projection in sigma: residual of an observation (0, 0)
  Eigen::Vector2d measured_;
  double inverse_sigma_;
  double phase_;
  Eigen::Vector2d by_readout_;
  Eigen::Vector2d by_half_;
};

/// Prior of the deviations, 1-sigma. It constrains deviations that the images do not determine, and
/// bounds those that a broken map would suggest: pixels of impossible aspect, rows that are read
/// for longer than a frame.
class DeviationPrior final : public ceres::SizedCostFunction<kNumbers, kNumbers> {
 public:
  explicit DeviationPrior(const CameraProblem& problem) {
    const double quarter = 0.25 * problem.height_normalised;
    const double late_s = problem.interval_s;
    inverse_ = Deviations{{0.5, 0.5, 0.2, quarter, quarter, late_s, late_s}}.cwiseInverse();
  }
  [[nodiscard]] DeviationInformation information() const {
    return DeviationInformation(inverse_.cwiseAbs2().asDiagonal());
  }
  /// Bound on deviations: only a broken map exceeds it.
  [[nodiscard]] bool allows(const Deviations& deviations) const {
    // In sigmas: of normal errors one in 370 is beyond.
    constexpr double kSigmas = 3.0;
    return inverse_.cwiseProduct(deviations).cwiseAbs().maxCoeff() < kSigmas;
  }
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    Eigen::Map<Deviations>{residuals} =
        inverse_.cwiseProduct(Eigen::Map<const Deviations>(parameters[0]));
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<DeviationInformation>{jacobians[0]} = inverse_.asDiagonal();
    }
    return true;
  }

 private:
  Deviations inverse_;
};

/// Copies of a problem's poses and points as Ceres's parameters, with the deviations. It is solved
/// several times, each time from the last result.
class DeviatingBundle {
 public:
  DeviatingBundle(const CameraProblem& whole, const BundleProblem& bundle, double cauchy_sigma)
      : bundle_(bundle),
        poses_(bundle.poses),
        points_(bundle.points_T.begin(), bundle.points_T.end()),
        loss_(cauchy_sigma),
        prior_(whole),
        ceres_(problem_options(&poses_)) {
    ceres_.AddResidualBlock(&prior_, nullptr, deviations_.data());
    for (std::size_t k = 0; k < bundle.poses.size(); ++k) {
      ceres_.AddParameterBlock(poses_.numbers(k), kPoseNumbers);
      if (bundle.pose_fixed[k] != 0) {
        ceres_.SetParameterBlockConstant(poses_.numbers(k));
      }
    }
    for (Eigen::Vector3d& point : points_) {
      ceres_.AddParameterBlock(point.data(), 3);
    }
    for (const BundleObservation& o : bundle.observations) {
      const auto k = static_cast<std::size_t>(o.pose);
      Eigen::Vector3d& point = points_[static_cast<std::size_t>(o.point)];
      const PoseMotion& motion = whole.motions[k];
      costs_.emplace_back(
          o, poses_[k], flow_of(bundle.poses[k], point, motion), motion.phase, whole);
      ceres_.AddResidualBlock(
          &costs_.back(), &loss_, poses_.numbers(k), point.data(), deviations_.data());
    }
  }

  /// @param fixed  the camera is constant
  BundleReport solve(bool fixed, int iterations_max) {
    if (fixed) {
      ceres_.SetParameterBlockConstant(deviations_.data());
    } else {
      ceres_.SetParameterBlockVariable(deviations_.data());
    }
    ceres::Solver::Options options = solver_options(iterations_max);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    // Least gain of a step. A focal length settles along a weak direction, and a gain of one in the
    // cost is 1.4 sigma.
    options.function_tolerance = 1e-7;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (Eigen::Vector3d& point : points_) {
      options.linear_solver_ordering->AddElementToGroup(point.data(), kPoints);
    }
    for (std::size_t k = 0; k < bundle_.poses.size(); ++k) {
      options.linear_solver_ordering->AddElementToGroup(poses_.numbers(k), kPoses);
    }
    options.linear_solver_ordering->AddElementToGroup(deviations_.data(), kCamera);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_, &summary);
    return report_of(summary);
  }

  [[nodiscard]] const Deviations& deviations() const { return deviations_; }
  [[nodiscard]] const DeviationPrior& prior() const { return prior_; }
  [[nodiscard]] bool is_plausible() const {
    return deviations_.allFinite() && prior_.allows(deviations_);
  }

  /// Information matrix of the deviations at the present bundle, points and poses eliminated.
  DeviationInformation information() {
    constexpr double kGauge = 1e-6;  // of the gauge: far below the information of any image
    const auto size = static_cast<Eigen::Index>(kPoseNumbers * bundle_.poses.size()) + kNumbers;
    const Eigen::Index others = size - kNumbers;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
    H.diagonal().head(others).setConstant(kGauge);
    poses_.PrepareForEvaluation(true, true);
    const std::vector<std::size_t> order = observations_by_point();
    Eigen::Matrix<double, 3, Eigen::Dynamic> W(3, size);
    for (std::size_t begin = 0; begin < order.size();) {
      const std::int32_t point = bundle_.observations[order[begin]].point;
      Eigen::Matrix3d V = kGauge * Eigen::Matrix3d::Identity();
      W.setZero();
      for (; begin < order.size() && bundle_.observations[order[begin]].point == point; ++begin) {
        add(order[begin], &H, &W, &V);
      }
      H.noalias() -= W.transpose() * (V.inverse() * W);
    }
    const Eigen::MatrixXd beside = H.topRightCorner(others, kNumbers);
    return H.bottomRightCorner<kNumbers, kNumbers>() -
           beside.transpose() * H.topLeftCorner(others, others).ldlt().solve(beside);
  }

 private:
  [[nodiscard]] std::vector<std::size_t> observations_by_point() const {
    std::vector<std::size_t> order(bundle_.observations.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return bundle_.observations[a].point < bundle_.observations[b].point;
    });
    return order;
  }

  /// Blocks of one observation: H of poses and deviations, V of its point, W between the two.
  void add(std::size_t index,
           Eigen::MatrixXd* H,
           Eigen::Matrix<double, 3, Eigen::Dynamic>* W,
           Eigen::Matrix3d* V) {
    const BundleObservation& o = bundle_.observations[index];
    const auto k = static_cast<std::size_t>(o.pose);
    Eigen::Vector2d residual;
    Eigen::Matrix<double, 2, kPoseNumbers, Eigen::RowMajor> by_pose;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
    ByDeviations by_deviations;
    const std::array<const double*, 3> parameters = {
        poses_.numbers(k), points_[static_cast<std::size_t>(o.point)].data(), deviations_.data()};
    std::array<double*, 3> jacobians = {by_pose.data(), by_point.data(), by_deviations.data()};
    if (!costs_[index].Evaluate(parameters.data(), residual.data(), jacobians.data())) {
      return;
    }
    if (bundle_.pose_fixed[k] != 0) {
      by_pose.setZero();
    }
    std::array<double, 3> loss{};  // the loss and its first two derivatives
    loss_.Evaluate(residual.squaredNorm(), loss.data());
    Eigen::Matrix<double, 2, kPoseNumbers + kNumbers> J;
    J << by_pose, by_deviations;
    const Eigen::Matrix<double, kPoseNumbers + kNumbers, kPoseNumbers + kNumbers> JJ =
        loss[1] * J.transpose() * J;
    const Eigen::Index at = kPoseNumbers * o.pose;
    H->block<kPoseNumbers, kPoseNumbers>(at, at) += JJ.topLeftCorner<kPoseNumbers, kPoseNumbers>();
    H->block<kPoseNumbers, kNumbers>(at, H->cols() - kNumbers) +=
        JJ.topRightCorner<kPoseNumbers, kNumbers>();
    H->bottomRightCorner<kNumbers, kNumbers>() += JJ.bottomRightCorner<kNumbers, kNumbers>();
    W->middleCols<kPoseNumbers>(at) += loss[1] * by_point.transpose() * by_pose;
    W->rightCols<kNumbers>() += loss[1] * by_point.transpose() * by_deviations;
    *V += loss[1] * by_point.transpose() * by_point;
  }

  BundleProblem bundle_;
  ChartedPoses poses_;
  std::vector<Eigen::Vector3d> points_;
  std::deque<DeviatingCost> costs_;
  ceres::CauchyLoss loss_;
  Deviations deviations_ = Deviations::Zero();
  DeviationPrior prior_;
  ceres::Problem ceres_;
};

}  // namespace

CameraFit adjust_camera(const CameraProblem& problem, const BundleOptions& options) {
  const BundlePart part(problem.bundle, options.observations_max);
  const std::size_t observations = part.problem().observations.size();
  if (observations == 0) {
    return {};
  }
  DeviatingBundle bundle(problem, part.problem(), options.cauchy_sigma);
  const BundleReport as_given = bundle.solve(true, options.iterations_max);
  const BundleReport as_found = bundle.solve(false, options.iterations_max);
  const DeviationInformation by_images = bundle.information();
  if (!as_given.usable || !as_found.usable || !bundle.is_plausible() || !by_images.allFinite()) {
    return {};
  }
  // Factor on the sigmas for correlated errors along a track: decision 0085 has two to three. A
  // misfit beyond the sigmas counts, too: half a square of two residuals is expected to be 1.
  constexpr double kAlike = 3.0;
  const double level =
      kAlike * kAlike * std::max(1.0, as_found.cost_after / static_cast<double>(observations));
  return {.usable = true,
          .value = bundle.deviations(),
          .information = by_images / level + bundle.prior().information(),
          .gain = 2.0 * (as_given.cost_after - as_found.cost_after) / level,
          .rates = rates_of(problem.motions),
          .cost_as_given = as_given.cost_after,
          .cost_as_found = as_found.cost_after,
          .observations = observations};
}

}  // namespace polhode
