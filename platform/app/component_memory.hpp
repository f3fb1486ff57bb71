// The memory of a run: planned, checked and acquired before anything else starts.
#pragma once

#include <cstddef>
#include <string>

#include "memory_plan.hpp"
#include "os/linux/memory/table_memory.hpp"

/// Where a component's tables lie, for debuggers and for hil/seu_campaign.py, which flips bits in
/// them. Nothing in the program reads it.
struct PolhodeTables {
  void* begin = nullptr;
  std::size_t bytes = 0;
};
extern "C" PolhodeTables polhode_tables;

namespace polhode::platform {

/// The pools, and the block that a component lives in.
class ComponentMemory {
 public:
  /// @param where  the configuration's name, for the message.
  /// @throws UnusableInput when the plan does not fit; RunFailure when the machine has not so much.
  ComponentMemory(const Parameters& parameters,
                  const std::string& where,
                  const MachineNeeds& machine);

  [[nodiscard]] std::span<std::byte> span() const { return tables_.span(); }
  [[nodiscard]] const MemoryPlan& plan() const { return plan_; }

 private:
  MemoryPlan plan_;
  TableMemory tables_;
};

}  // namespace polhode::platform
