// Handling of a run's own faults: memory is exhausted, the reserve too, or an assertion of the
// component failed. The state goes to the disk, then the program ends.
#pragma once

#include "app/checkpoint_writer.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// As long as it lives such a failure leaves a checkpoint behind. Made on the thread that steps.
/// Libraries draw memory between what the component does to its tables, so these are whole when
/// memory is exhausted. An assertion may find them in the middle of a change: a state that is not
/// valid is not written (may_be_saved()), nor is one within kFramesProven frames of a start from a
/// checkpoint. The frame of the failed step is left out by the next start. Where another thread
/// failed the last checkpoint that was written stays.
class CheckpointOnFailure {
 public:
  CheckpointOnFailure(const Component& component, CheckpointWriter& writer);
  ~CheckpointOnFailure();
  CheckpointOnFailure(const CheckpointOnFailure&) = delete;
  CheckpointOnFailure& operator=(const CheckpointOnFailure&) = delete;
  CheckpointOnFailure(CheckpointOnFailure&&) = delete;
  CheckpointOnFailure& operator=(CheckpointOnFailure&&) = delete;
};

}  // namespace polhode::platform
