// summary.json: description, results and cost of a run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/machine.hpp"
#include "app/own_structure_file.hpp"
#include "app/run_record.hpp"
#include "app/timings.hpp"
#include "camera/replay/sequence.hpp"
#include "memory_plan.hpp"
#include "os/linux/deadline.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

struct SummaryInput {
  const RunRecord& record;
  const Timings& timings;
  const Counters& counters;
  const Parameters& parameters;
  const Sequence& sequence;
  std::vector<std::string> remarks;  ///< further remarks for the reader
  std::string config_hash;
  std::string bus_sha256;
  std::uint64_t bus_octets = 0;
  const OwnStructureFile& own;
  const MemoryPlan& plan;
  PoolReport pools;  ///< over the frames
  const DeadlineMonitor& deadline;
  MachineUse at_start;      ///< before the first frame
  MachineUse after_frames;  ///< before the end's re-estimation
  MachineUse at_end;
  double wall_s = 0.0;    ///< of the frame loop
  double finish_s = 0.0;  ///< of the re-estimation at the end
};

/// One plain sentence: was the target acquired, on how many frames is there a pose, its rotation;
/// and the contradicted values of the stated camera.
std::string result_sentence(const RunRecord& record,
                            const Counters& counters,
                            const CameraParameters& camera);

void write_summary(const std::filesystem::path& file, const SummaryInput& input);

}  // namespace polhode::platform
