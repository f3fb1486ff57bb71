#include "motion/mend.hpp"

#include "base/validity.hpp"
#include "motion/disturbance.hpp"
#include "motion/estimator.hpp"
#include "motion/soundness.hpp"

namespace polhode {
namespace {

/// Drops invalid poses, and poses that are not earlier than the next kept one.
std::uint32_t drop_poses(std::int64_t now_ns, PoseHistory* poses) {
  if (poses->size() > PoseHistory::capacity()) {
    poses->clear();
    return 1;
  }
  std::uint32_t dropped = 0;
  for (std::size_t i = poses->size(); i-- > 0;) {
    const bool earlier =
        i + 1 == poses->size() || (*poses)[i].timestamp_ns < (*poses)[i + 1].timestamp_ns;
    if (!earlier || !is_valid((*poses)[i], now_ns)) {
      poses->erase(i);
      ++dropped;
    }
  }
  return dropped;
}

}  // namespace

Repair repair(std::int64_t now_ns, MotionEstimate* motion) {
  if (is_valid(*motion, now_ns)) {
    return {};
  }
  Repair done{.entries = drop_poses(now_ns, &motion->recent) + drop_poses(now_ns, &motion->past)};
  if (done.entries > 0) {
    pass_over_pose(motion);  // it is unknown which poses were inconsistent
  }
  if (!is_valid_of_repeats(*motion, now_ns)) {
    forget_seen(motion);
    ++done.entries;
  }
  if (!is_valid(motion->model, now_ns)) {
    replace_model({}, motion);
    ++done.entries;
  }
  if (!is_valid(*motion, now_ns)) {
    reset_poses(motion);
    motion->R_IC.setIdentity();
    motion->observer_known = false;
    motion->departures = 0;
    done.reset = true;
  }
  return done;
}

}  // namespace polhode
