// The target as a rigid body in free motion: fitted to its poses, and where it will be.
//
// Axes I do not rotate; their origin is the observer. For an observer that keeps its attitude they
// are C's, and names in C of this stage mean C. Where the observer rotates, the pipeline rotates
// poses and answers.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/result.hpp"
#include "motion/known_body.hpp"
#include "motion/model.hpp"
#include "motion/options.hpp"
#include "motion/pose_history.hpp"

namespace polhode {

/// All input of a fit; plain data, for another core.
struct MotionSnapshot {
  PoseHistory poses;  ///< in I, errors of single frames, without the map's drift
  PoseCovariance drift = PoseCovariance::Zero();  ///< error that poses of one visible face share
  double body_radius = 1.0;                       ///< unit of the poses, > 0
  MotionOptions options;
  RigidModel previous;   ///< where accepted, the fit starts from it
  KnownBody known_body;  ///< of an earlier pass, a prior as long as the poses do not contradict it
};

/// Workspace of a fit.
struct MotionWorkspace {
  FixedVector<AttitudeSample, limits::kMotionPoses> attitudes;
  FixedVector<PositionSample, limits::kMotionPoses> positions;
  FixedVector<Eigen::Vector3d, limits::kMotionPoses> residuals;  ///< in sigmas as declared
};

/// The orbit that the options name, its time 0 at `reference_ns`; not active where they name none.
Orbit orbit_at(const MotionOptions& options, std::int64_t reference_ns);

/// The rotation, its reference at `reference_ns`. Starts from the previous model where that is
/// accepted and chi-square agrees, else from nothing. @errors as solve_rotation().
Result<RotationSolution> fit_attitudes(const RotationProblem& problem,
                                       std::int64_t reference_ns,
                                       RigidModel previous);

/// Fits rotation, then translation, to all poses. Where chi-square refuses that: to the later half,
/// then to the later quarter. Residuals give the noise level, and their correlation widens the
/// covariance. The answer's reference is the last pose.
/// @return a model with its status. Unless accepted, nothing else of it is valid.
/// @cost   about 2 ms for 300 poses that the previous model fits; 40 times that from nothing.
RigidModel fit_rigid_model(const MotionSnapshot& snapshot, MotionWorkspace& workspace);

/// The same model with its unknowns at another time. False, model unchanged, when that time is out
/// of reach.
bool move_reference(std::int64_t timestamp_ns, RigidModel& model);

struct MotionPrediction {
  std::int64_t timestamp_ns = 0;
  Pose pose;  ///< of T in I
  PoseCovariance covariance = PoseCovariance::Zero();
  Eigen::Vector3d w_T_rad_s = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_w_T = Eigen::Matrix3d::Zero();
  Eigen::Vector3d v_I = Eigen::Vector3d::Zero();  ///< of T's origin: the mass centre's, and that of
                                                  ///< the rotation about it
  Eigen::Matrix3d covariance_v_I = Eigen::Matrix3d::Zero();
  bool translation_known = false;  ///< else position and velocity are not valid
};

/// The motion at any time, earlier or later. @errors Degenerate (model not accepted, or the time is
/// beyond its reach).
Result<MotionPrediction> predict_motion(const RigidModel& model, std::int64_t timestamp_ns);

/// The same from a state and derivative that advance() has integrated from the model's reference.
/// So a long prediction can be computed in parts. The time is the state's, after the reference.
MotionPrediction predict_at(const RigidModel& model,
                            const RotationState& state,
                            const RotationDerivative& derivative);

/// The next pose, from the last one by the model's motion in between. The map's drift, which both
/// share, cancels.
Result<MotionPrediction> predict_from(const RigidModel& model,
                                      const PoseSample& last,
                                      std::int64_t timestamp_ns);

/// The same, with the change of the map's drift over the rotation from one pose to the other.
/// @param drift_I  error that poses of one visible face share.
Result<MotionPrediction> predict_on(const RigidModel& model,
                                    const PoseSample& from,
                                    const PoseCovariance& drift_I,
                                    std::int64_t timestamp_ns);

/// chi2 of a pose against a prediction of it, by the covariance of both: 6 numbers, or 3 where the
/// translation is not known.
double chi2_between(const MotionPrediction& predicted, const PoseSample& sample);

/// chi2 of a pose against the model, by the covariance of both and the drift: 6 numbers, or 3 where
/// the translation is not known. @errors Degenerate as above.
Result<double> chi2_against(const RigidModel& model,
                            const PoseSample& sample,
                            const PoseCovariance& drift);

}  // namespace polhode
