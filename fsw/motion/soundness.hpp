// Whether the remembered motion holds what may be computed with: after it came from a file, or lay
// in memory that radiation reaches.
#pragma once

#include <cstdint>

#include "motion/estimator.hpp"

namespace polhode {

/// Numbers finite, rotations orthonormal, times increasing and not after `now_ns`, covariances of
/// poses positive definite, the model's kind one that exists.
bool is_valid(const MotionEstimate& motion, std::int64_t now_ns);

/// Parts of it:
bool is_valid(const PoseSample& sample, std::int64_t now_ns);
bool is_valid(const RigidModel& model, std::int64_t now_ns);
bool is_valid(const KnownBody& body);
/// What the next pose is held against, to tell a repeat.
bool is_valid_of_repeats(const MotionEstimate& motion, std::int64_t now_ns);

}  // namespace polhode
