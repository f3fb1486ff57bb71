// The whole memory of a run, decided before it starts: own tables, the libraries' pools, stacks,
// images, the program itself.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "os/linux/memory/region.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

struct PlanRow {
  std::string name;
  std::size_t bytes = 0;
};

/// The most that one library call takes from its pool at the sizes that the configuration allows.
struct CallCost {
  std::string name;
  Pool pool = Pool::kStep;
  std::size_t bytes = 0;
};

struct MemoryPlan {
  std::vector<PlanRow> tables;  ///< the component's own, one by one
  std::vector<CallCost> calls;
  std::vector<PlanRow> others;  ///< images, stacks, the program with its libraries
  PoolBytes pools{};
  std::size_t tables_bytes = 0;
  std::size_t total_bytes = 0;
  std::size_t limit_bytes = 0;
  std::string problem;  ///< why it does not fit; empty when it does
};

/// Needs of a run beside the estimator, for its frames and packets.
struct MachineNeeds {
  std::vector<PlanRow> rows;      ///< in memory of their own
  std::size_t general_bytes = 0;  ///< from the general pool
  std::size_t decoder_bytes = 0;  ///< from the same, while a frame's file is decoded
};

/// @param parameters checked, with a camera.
MemoryPlan plan_memory(const Parameters& parameters, const MachineNeeds& machine = {});

/// The plan as a table of text.
std::string text_of(const MemoryPlan& plan);

/// Most that one job may take from its pool; admission requires this much before it runs.
std::size_t job_worst_case(const Parameters& parameters);

}  // namespace polhode::platform
