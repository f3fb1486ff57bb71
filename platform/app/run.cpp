#include "app/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>

#include "app/beginning.hpp"
#include "app/checkpoint_writer.hpp"
#include "app/component_memory.hpp"
#include "app/exposure_control.hpp"
#include "app/failure.hpp"
#include "app/frames_trapped.hpp"
#include "app/live_camera_choice.hpp"
#include "app/live_run.hpp"
#include "app/machine_needs.hpp"
#include "app/own_structure_file.hpp"
#include "app/places.hpp"
#include "app/run_json.hpp"
#include "app/warm_up.hpp"
#include "errors.hpp"
#include "os/linux/memory/lock.hpp"
#include "os/linux/memory/region.hpp"
#include "os/linux/priority.hpp"
#include "os/linux/stop_request.hpp"
#include "parameters/load.hpp"
#include "parameters/machine_options.hpp"
#include "parameters/sha256.hpp"
#include "parameters/transport_options.hpp"
#include "pipeline/own_structure.hpp"
#include "recording/export.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<Recorder> make_recorder(const MachineOptions& machine,
                                        const Parameters& parameters,
                                        const OwnStructureFile& own,
                                        std::span<const std::uint8_t> checkpoint) {
  const RecordingOptions& request = machine.recording;
  if (request.folder.empty()) {
    return nullptr;
  }
  constexpr std::uint64_t kMega = 1'000'000;
  const std::uint64_t folder_bytes = kMega * static_cast<std::uint64_t>(request.disk_mb_max);
  // Two files at least, so that there is something left when the oldest goes.
  const std::uint64_t segment_bytes =
      std::min(kMega * static_cast<std::uint64_t>(request.segment_mb), folder_bytes / 4);
  auto recorder = std::make_unique<Recorder>(
      RecorderOptions{
          .folder = request.folder,
          .run_utc_ns = utc_now_ns(),
          .limits = {.segment_bytes_max = segment_bytes, .folder_bytes_max = folder_bytes},
          .slots = static_cast<std::size_t>(request.slots),
          .complete = request.complete},
      begin_text(kVersion, own.sha256(), canonical_text(parameters)),
      recorded_frame_bytes(parameters.camera));
  if (!checkpoint.empty()) {
    recorder->checkpoint(checkpoint);
  }
  return recorder;
}

Component& make_component(const ComponentMemory& memory,
                          const Parameters& parameters,
                          const OwnStructureFile& own,
                          const RunArguments& arguments) {
  Result<Component*> made = Component::create(memory.span(), parameters);
  if (!made) {
    throw UnusableInput(fmt::format("{}: {}", arguments.config.string(), made.error().message));
  }
  set_own_structure(own.hook(), made.value());
  return *made.value();
}

void open_packet_log(const fs::path& folder, std::optional<PacketLog>* packets) {
  if (folder.empty()) {
    return;
  }
  packets->emplace(folder / "bus.ccsds");
}

MachineNeeds needs_of(const MachineOptions& machine,
                      const TransportOptions& transport,
                      const CameraParameters& camera,
                      const ChosenCamera& chosen) {
  MachineNeeds needs = live_needs(machine, transport, camera);
  if (chosen.sequence() != nullptr) {
    add_sequence(*chosen.sequence(), &needs);
  }
  return needs;
}

/// Requests locked memory, core and priority from the machine; reports refusals.
PlatformFacts settle_in(const RunOptions& request,
                        const ServiceManager& manager,
                        std::uint32_t restarts) {
  const std::string not_locked = request.lock_memory ? lock_memory() : "run.lock_memory is false";
  const std::string unbound = request.core >= 0 ? take_core(request.core) : "";
  const std::string ordinary =
      request.priority > 0 ? take_priority(request.priority) : "none is wished";
  if (request.lock_memory && !not_locked.empty()) {
    report_line("%s", not_locked.c_str());
  }
  if (!unbound.empty()) {
    report_line("%s", unbound.c_str());
  }
  if (request.priority > 0 && !ordinary.empty()) {
    report_line("%s", ordinary.c_str());
  }
  return {.watchdog = manager.watchdog_ns() > 0,
          .locked_memory = not_locked.empty(),
          .real_time = ordinary.empty(),
          .restarts = static_cast<std::uint16_t>(restarts)};
}

WorkerOptions worker_options(const Parameters& parameters, const RunOptions& request) {
  return {.own_thread = has_work_beside(parameters.jobs),
          .priority = std::max(0, request.priority - 1),
          .job_bytes = job_worst_case(parameters)};
}

/// From the first frame to the last no memory and no thread is requested. An exception in it counts
/// as a crash for the next start.
LiveEnd run_sealed(LiveParts& parts, const RunOptions& request, bool memory_trap) {
  seal_memory();
  const FramesTrapped trapped(memory_trap);
  LiveEnd end = LiveEnd::kStopped;
  try {
    end = run_live(parts,
                   {.checkpoint_frames = request.checkpoint_frames,
                    .start_s_max = request.start_s_max,
                    .frames_max = request.frames_max});
  } catch (...) {
    leave_crash_mark();
    throw;
  }
  parts.worker.finish();
  trapped.end();
  unseal_memory();
  return end;
}

/// The state, where this run has taken it further, and the report.
void leave_behind(const RunJsonInput& input, const fs::path& folder) {
  const LiveParts& parts = input.parts;
  if (parts.checkpoint != nullptr && parts.counts.frames_accepted > 0) {
    parts.checkpoint->write_now(parts.component, parts.counts.last_step);
  }
  if (!folder.empty()) {
    write_run_json(folder / "run.json", input);
  }
}

/// @throws RunFailure when there was no camera.
void report_end(LiveEnd end,
                const LiveCounts& counts,
                const LiveCamera& from,
                const RunOptions& request) {
  if (end == LiveEnd::kNoCamera) {
    throw RunFailure(fmt::format("no camera within {} s: {}", request.start_s_max, from.state()));
  }
  const CameraCounters& camera = from.counters();
  report_line("%s: %u frames, %u with a pose; %u missing, %u damaged, %u passed over",
              end == LiveEnd::kPlayed ? "at the end" : "stopped",
              counts.frames_accepted,
              counts.frames_with_pose,
              camera.frames_missing,
              camera.frames_damaged,
              frames_passed_over(camera, counts));
}

/// Where checkpoints are requested: one now and then, and a last one when the run ends by a fault
/// of its own.
void open_checkpoint(const RunOptions& options,
                     const Beginning& beginning,
                     Component& component,
                     std::optional<CheckpointWriter>* checkpoint,
                     std::optional<CheckpointOnFailure>* last_words) {
  if (!options.checkpoint.empty()) {
    checkpoint->emplace(
        options.checkpoint, beginning.identity(), beginning.restarts(), beginning.key());
    last_words->emplace(component, **checkpoint);
  }
}

/// Reports who may give commands, where the configuration leaves it open.
void report_commands(const CommandPorts& ports) {
  if (ports.open_to_all()) {
    report_line(
        "commands are unauthenticated: all who reach the port may give them "
        "(commands.unauthenticated = true)");
  }
  if (!ports.guard().remark().empty()) {
    report_line("commands.window: %s", ports.guard().remark().c_str());
  }
}

std::unique_ptr<LiveCounts> make_counts(double frame_ms) {
  auto counts = std::make_unique<LiveCounts>();
  counts->deadline = DeadlineMonitor(frame_ms);
  return counts;
}

}  // namespace

void run_command(const RunArguments& arguments) {
  Configuration configuration = load_configuration(arguments.config, arguments.settings);
  const MachineOptions machine = load_machine_options(arguments.config, arguments.settings);
  listen_for_stop();  // of now on signals end the run in order, also while the camera is opened
  ChosenCamera chosen(arguments.config, machine, &configuration.parameters);
  const std::vector<Descriptor> places = prepare_places(arguments.config, machine);
  const Parameters& parameters = configuration.parameters;
  const TransportOptions transport =
      load_live_transport_options(arguments.config, arguments.settings);
  const auto key = key_of(transport.transport.commands);  // before anything starts
  const ComponentMemory memory(parameters,
                               arguments.config.string(),
                               needs_of(machine, transport, parameters.camera, chosen));
  const OwnStructureFile own(transport.own_structure_file, parameters.camera);
  report_line("warmed up: %d poses of a made-up body", warm_up(memory, parameters));
  Component& component = make_component(memory, parameters, own, arguments);
  const std::string config_hash = sha256_of(canonical_text(parameters));
  Beginning beginning(machine, config_hash, key);
  beginning.restore(component);
  report_line("start %s", beginning.how().c_str());
  std::optional<PacketLog> packets;
  open_packet_log(machine.run.folder, &packets);
  const auto recorder = make_recorder(machine, parameters, own, beginning.bytes());
  beginning.release_bytes();
  std::optional<CheckpointWriter> checkpoint;
  std::optional<CheckpointOnFailure> last_words;
  open_checkpoint(machine.run, beginning, component, &checkpoint, &last_words);
  ServiceManager manager;
  LiveReport report(manager, machine.run.report_s);
  const auto counts = make_counts(parameters.budget.frame_ms);
  ExposureControl exposure({.enabled = machine.device.exposure_control,
                            .gain_factor_max = machine.device.gain_factor_max});
  Worker worker(worker_options(parameters, machine.run));
  Transports transports(transport.transport, utc_now_ns());
  report_commands(transports.commands());
  LiveCamera& camera = chosen.start(parameters.camera);
  // After all that takes memory.
  PlatformTelemetry telemetry(parameters.bus,
                              settle_in(machine.run, manager, beginning.restarts()));
  LiveParts parts{.component = component,
                  .worker = worker,
                  .camera = camera,
                  .manager = manager,
                  .report = report,
                  .counts = *counts,
                  .transports = transports,
                  .telemetry = telemetry,
                  .packets = packets ? &*packets : nullptr,
                  .recorder = recorder.get(),
                  .checkpoint = checkpoint ? &*checkpoint : nullptr,
                  .crash = beginning.watch(),
                  .exposure = exposure};
  manager.ready();
  const LiveEnd end = run_sealed(parts, machine.run, arguments.memory_trap);
  manager.stopping();
  leave_behind({.parts = parts, .config_hash = config_hash, .beginning = beginning.how()},
               machine.run.folder);
  report_end(end, *counts, camera, machine.run);
}

}  // namespace polhode::platform
