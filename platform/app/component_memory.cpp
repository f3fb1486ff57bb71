#include "app/component_memory.hpp"

#include <fmt/format.h>

#include "errors.hpp"

extern "C" {
[[gnu::used]] PolhodeTables polhode_tables;
}

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
    : plan_(acquired(parameters, where, machine)), tables_(memory_needed(parameters).total) {
  polhode_tables = {.begin = tables_.span().data(), .bytes = tables_.span().size()};
}

}  // namespace polhode::platform
