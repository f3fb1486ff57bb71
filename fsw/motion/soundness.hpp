// Validity checks of the motion's state, after it was read from a file or was exposed to radiation
// in memory.
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
/// The stored last pose, with which the next one is compared to detect a repeat.
bool is_valid_of_repeats(const MotionEstimate& motion, std::int64_t now_ns);

}  // namespace polhode
