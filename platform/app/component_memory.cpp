#include "app/component_memory.hpp"

#include <fmt/format.h>

#include "errors.hpp"

namespace polhode::platform {
namespace {

MemoryPlan acquired(const Parameters& parameters,
                    const std::string& where,
                    const MachineNeeds& machine) {
  MemoryPlan plan = plan_memory(parameters, machine);
  if (!plan.problem.empty()) {
    throw UnusableInput(fmt::format(
        "{}: the memory does not fit: {} (polhode check --memory)", where, plan.problem));
  }
  open_pools(plan.pools);
  return plan;
}

}  // namespace

ComponentMemory::ComponentMemory(const Parameters& parameters,
                                 const std::string& where,
                                 const MachineNeeds& machine)
    : plan_(acquired(parameters, where, machine)), tables_(memory_needed(parameters).total) {}

}  // namespace polhode::platform
