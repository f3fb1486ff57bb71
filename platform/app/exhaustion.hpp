// What is still done when memory is exhausted, the reserve too: the state goes to the disk, then
// the program ends.
#pragma once

#include "app/checkpoint_writer.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// As long as it lives an exhausted reserve leaves a checkpoint behind. Made on the thread that
/// steps: libraries draw memory between what the component does to its tables, so these are whole
/// then. Where another thread asked in vain the tables may be in the middle of a change, and the
/// last checkpoint that was written stays.
class CheckpointOnExhaustion {
 public:
  CheckpointOnExhaustion(const Component& component, CheckpointWriter& writer);
  ~CheckpointOnExhaustion();
  CheckpointOnExhaustion(const CheckpointOnExhaustion&) = delete;
  CheckpointOnExhaustion& operator=(const CheckpointOnExhaustion&) = delete;
  CheckpointOnExhaustion(CheckpointOnExhaustion&&) = delete;
  CheckpointOnExhaustion& operator=(CheckpointOnExhaustion&&) = delete;
};

}  // namespace polhode::platform
