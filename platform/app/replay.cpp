#include "app/replay.hpp"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "app/checkpoint_start.hpp"
#include "app/component_memory.hpp"
#include "app/finish.hpp"
#include "app/frames_trapped.hpp"
#include "app/machine.hpp"
#include "app/machine_needs.hpp"
#include "app/mask_log.hpp"
#include "app/model_file.hpp"
#include "app/motion_csv.hpp"
#include "app/next_input.hpp"
#include "app/observations.hpp"
#include "app/output_folder.hpp"
#include "app/own_structure_file.hpp"
#include "app/progress.hpp"
#include "app/run_record.hpp"
#include "app/scale_frame.hpp"
#include "app/servicer_attitude.hpp"
#include "app/summary.hpp"
#include "app/timings.hpp"
#include "app/warnings.hpp"
#include "camera/replay/depth.hpp"
#include "camera/replay/file_camera.hpp"
#include "camera/replay/sequence.hpp"
#include "errors.hpp"
#include "os/linux/deadline.hpp"
#include "os/linux/memory/region.hpp"
#include "os/linux/worker.hpp"
#include "parameters/load.hpp"
#include "parameters/machine_options.hpp"
#include "parameters/sha256.hpp"
#include "parameters/transport_options.hpp"
#include "pipeline/component.hpp"
#include "pipeline/ground_view.hpp"
#include "pipeline/own_structure.hpp"
#include "print_stderr.hpp"
#include "transport/command_file.hpp"
#include "transport/file/packet_file.hpp"
#include "transport/transports.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The files that grow frame by frame.
struct FrameFiles {
  FrameFiles(const fs::path& folder, std::size_t frames)
      : motion(folder / "motion.csv"),
        bus(folder / "bus.ccsds"),
        table(folder / "observations.csv"),
        spool(folder / ".observations.spool", frames) {
    motion.write(motion_csv_header());
  }
  OutputFile motion;
  PacketFile bus;
  ObservationTable table;
  ObservationSpool spool;
};

/// Holds frames back until their time stamps are due.
class Pace {
 public:
  Pace(bool realtime, std::int64_t first_ns) : realtime_(realtime), first_ns_(first_ns) {}
  void wait_for(std::int64_t timestamp_ns) const {
    if (realtime_) {
      std::this_thread::sleep_until(start_ + std::chrono::nanoseconds(timestamp_ns - first_ns_));
    }
  }

 private:
  bool realtime_;
  std::int64_t first_ns_;
  Clock::time_point start_ = Clock::now();
};

/// State of a replay from its first frame to its last.
struct Run {
  const Sequence& sequence;
  const ServicerAttitude& servicer;
  Component& component;
  FileCamera camera;
  CommandFile commands;
  Transports transports;
  Worker worker;
  DeadlineMonitor deadline;
  FrameFiles files;
  Timings timings;
  RunRecord record;
  std::vector<MotionState> published;
  std::vector<FrameUse> uses;
  std::unique_ptr<MaskLog> masks;  ///< only on request
};

/// Timings of the frames.
struct RunCost {
  MachineUse at_start;
  MachineUse after_frames;
  PoolReport pools;
  double wall_s = 0.0;
};

void write_frame(
    Run& run, std::size_t index, const Frame& frame, const StepOutput& out, std::int64_t step_us) {
  const MotionRow row{.frame = index,
                      .timestamp_ns = frame.timestamp_ns,
                      .used = out.use == FrameUse::kUsed,
                      .step_us = step_us};
  run.files.motion.write(motion_csv_row(row, out.motion));
  run.files.bus.append(out.packets);
  run.files.table.append(index, frame.timestamp_ns, out.observations);
  run.files.spool.append(out.observations);
  run.published.push_back(out.motion);
  run.uses.push_back(out.use);
}

const StepOutput& timed_step(Run& run, const Frame& frame) {
  StepInput input = next_input(run.component, run.worker, frame);
  input.commands = run.commands.due(frame.timestamp_ns);
  input.q_IC = run.servicer.attitude_at(frame.timestamp_ns);
  for (const auto duration : run.worker.last_durations()) {
    run.timings.job.add(duration);
  }
  const PoolScope scope(Pool::kStep);
  run.timings.start_step();
  return run.component.step(input);
}

void run_frames(Run& run, bool realtime) {
  FileCamera& camera = run.camera;
  Progress progress(run.sequence.frames.size());
  const Pace pace(realtime, run.sequence.frames.front().timestamp_ns);
  Frame frame;
  for (;;) {
    const Clock::time_point before = Clock::now();
    if (!camera.next(frame)) {
      return;
    }
    run.timings.add_read(Clock::now() - before);
    pace.wait_for(frame.timestamp_ns);
    const StepOutput& out = timed_step(run, frame);
    const std::int64_t step_us = run.timings.end_step();
    run.deadline.add(step_us);
    run.worker.submit(out.jobs);
    run.transports.send(out.packets);
    if (!frame.readable && run.record.bad_frames.size() < kBadFramesListed) {
      progress.note(fmt::format("frame {} is not used: {}", camera.index(), camera.refusal()));
    }
    write_frame(run, camera.index(), frame, out, step_us);
    if (run.masks != nullptr) {
      run.masks->append(camera.index(), out, view_of(run.component));
    }
    add_frame(run.record, camera.index(), out, camera.refusal(), frame.timestamp_ns);
    progress.update(camera.index() + 1, out.motion);
  }
}

CommandFile commands_of(const fs::path& file, const Parameters& parameters) {
  return file.empty() ? CommandFile() : CommandFile(file, parameters.bus.apid_first);
}

/// The configuration with the sequence's camera, checked as a whole.
Parameters parameters_for(const ReplayArguments& arguments, const Sequence& sequence) {
  Configuration configuration = load_configuration(arguments.config, arguments.settings);
  // Only a live run uses these; a mistake in them is reported all the same.
  (void)load_machine_options(arguments.config, arguments.settings);
  configuration.parameters.camera = sequence.camera;
  if (const auto problem = check(configuration.parameters)) {
    throw UnusableInput(fmt::format("{}: {}", arguments.config.string(), problem->message));
  }
  check_scale_frame(configuration, sequence);
  return configuration.parameters;
}

/// The model that is given, and the place of the one that is to be left.
void prepare_models(const ReplayArguments& arguments, Component& component) {
  const fs::path& left = arguments.save_model;
  if (!left.empty()) {
    check_model_place(left);
  }
  if (is_own_file(left, arguments.out)) {
    throw UnusableInput(
        fmt::format("--save-model {}: is a file of the results in --out", left.string()));
  }
  const fs::path& file = arguments.model;
  TargetModelFacts facts;
  const std::string refusal = file.empty() ? "" : load_model_file(file, &component, &facts);
  if (!refusal.empty()) {
    throw UnusableInput(fmt::format("--model {}: {}", file.string(), refusal));
  }
}

/// A model by which the target was not recognised is of another one, and stays.
void leave_model(const ReplayArguments& arguments, const Run& run) {
  const fs::path& file = arguments.save_model;
  std::error_code problem;
  if (!file.empty() && !is_recognised(run.record) &&
      fs::equivalent(file, arguments.model, problem)) {
    throw RunFailure(
        fmt::format("{}: stays as it was: the target was not recognised by it", file.string()));
  }
  if (!file.empty()) {
    write_model_file(file, run.component);
  }
}

Component& make_component(const ComponentMemory& memory,
                          const Parameters& parameters,
                          const OwnStructureFile& own,
                          const ReplayArguments& arguments) {
  Result<Component*> made = Component::create(memory.span(), parameters);
  if (!made) {
    throw UnusableInput(fmt::format("{}: {}", arguments.config.string(), made.error().message));
  }
  set_own_structure(own.hook(), made.value());
  if (!arguments.checkpoint.empty()) {
    start_from_checkpoint(arguments.checkpoint,
                          "--checkpoint " + arguments.checkpoint.string(),
                          parameters,
                          *made.value());
  }
  prepare_models(arguments, *made.value());
  return *made.value();
}

MachineNeeds needs_of(const TransportOptions& options, const Sequence& sequence) {
  MachineNeeds needs = transport_needs(options, sequence.camera);
  add_sequence(sequence, &needs);
  return needs;
}

/// From the first frame to the last no memory and no thread is requested.
RunCost run_sealed(Run& run, const ReplayArguments& arguments) {
  RunCost cost{.at_start = machine_use(), .after_frames = {}, .pools = {}};
  const Clock::time_point start = Clock::now();
  reset_pool_peaks();
  seal_memory();
  const FramesTrapped trapped(arguments.memory_trap);
  run_frames(run, arguments.realtime);
  run.worker.finish();
  trapped.end();
  cost.pools = report_pools();
  unseal_memory();  // the end of a replay is work for the ground
  cost.wall_s = seconds_since(start);
  run.transports.flush();
  cost.after_frames = machine_use();
  return cost;
}

CameraReport finish_files(Run& run, const fs::path& folder) {
  run.files.motion.close();
  run.files.table.close();
  if (run.masks) {
    run.masks->close();
  }
  return finish_replay(run.component,
                       run.sequence,
                       {.published = run.published,
                        .uses = run.uses,
                        .observations = run.files.spool,
                        .servicer = run.servicer},
                       folder);
}

/// @return the printed remarks.
std::vector<std::string> print_remarks(const FileCamera& camera) {
  std::vector<std::string> remarks;
  for (const std::string& remark :
       {camera.orientation_remark(), camera.depth_remark(), camera.mixed_remark()}) {
    if (!remark.empty()) {
      print_stderr("polhode: {}\n", remark);
      remarks.push_back(remark);
    }
  }
  return remarks;
}

void print_result(const Run& run, const fs::path& out) {
  fmt::print("{}\nwritten to {}\n",
             result_sentence(run.record, run.component.counters(), run.sequence.camera),
             out.string());
  const std::size_t frames = run.sequence.frames.size();
  if (run.component.counters().frames_unreadable == frames) {
    throw UnusableInput(fmt::format(
        "{}: none of its {} images can be read", run.sequence.image_folder.string(), frames));
  }
}

/// Prints warnings on the sequence, and the bit depth assumed where the arguments do not give it.
Sequence open_with_warnings(const ReplayArguments& arguments) {
  Sequence sequence = open_sequence(arguments.sequence, arguments.pixels);
  const std::string remark =
      arguments.pixels.depth_bits == 0 ? depth_remark(sequence.depth_bits) : "";
  if (!remark.empty()) {
    print_stderr("polhode: {}: {}\n", sequence.image_folder.string(), remark);
  }
  print_warnings(sequence.warnings);
  return sequence;
}

}  // namespace

void replay(const ReplayArguments& arguments) {
  const Sequence sequence = open_with_warnings(arguments);
  const ServicerAttitude servicer = ServicerAttitude::of_sequence(arguments.sequence);
  const Parameters parameters = parameters_for(arguments, sequence);
  const TransportOptions options = load_transport_options(arguments.config, arguments.settings);
  CommandFile commands = commands_of(
      arguments.commands.empty() ? options.commands_file : arguments.commands, parameters);
  const ComponentMemory memory(parameters, arguments.config.string(), needs_of(options, sequence));
  const OwnStructureFile own(options.own_structure_file, parameters.camera);
  Component& component = make_component(memory, parameters, own, arguments);
  const std::string config_hash = sha256_of(canonical_text(view_of(component).parameters));
  Transports transports({.send = options.transport.send, .receive = {}});
  const Descriptor lock = prepare_output_folder(arguments.out);  // last: an earlier run's files go
  const std::size_t frames = sequence.frames.size();
  Run run{.sequence = sequence,
          .servicer = servicer,
          .component = component,
          .camera = FileCamera(sequence),
          .commands = std::move(commands),
          .transports = std::move(transports),
          .worker = Worker({.own_thread = !arguments.one_core && has_work_beside(parameters.jobs),
                            .latency_ms_max = arguments.job_latency_ms,
                            .job_bytes = job_worst_case(parameters)}),
          .deadline = DeadlineMonitor(parameters.budget.frame_ms),
          .files = FrameFiles(arguments.out, frames),
          .timings = Timings(frames),
          .record = {},
          .published = {},
          .uses = {},
          .masks = arguments.masks ? std::make_unique<MaskLog>(arguments.out) : nullptr};
  run.published.reserve(frames);
  run.uses.reserve(frames);
  component.set_stage_hook(Timings::hook, &run.timings);
  run.record.model = arguments.model.string();
  const RunCost cost = run_sealed(run, arguments);
  const std::string bus_sha256 = run.files.bus.finish();
  const Clock::time_point finish_initialisation = Clock::now();
  run.record.camera = finish_files(run, arguments.out);
  write_summary(arguments.out / "summary.json",
                {.record = run.record,
                 .timings = run.timings,
                 .counters = component.counters(),
                 .parameters = parameters,
                 .sequence = sequence,
                 .remarks = print_remarks(run.camera),
                 .config_hash = config_hash,
                 .bus_sha256 = bus_sha256,
                 .bus_octets = run.files.bus.octets(),
                 .own = own,
                 .plan = memory.plan(),
                 .pools = cost.pools,
                 .deadline = run.deadline,
                 .at_start = cost.at_start,
                 .after_frames = cost.after_frames,
                 .at_end = machine_use(),
                 .wall_s = cost.wall_s,
                 .finish_s = seconds_since(finish_initialisation)});
  print_result(run, arguments.out);
  leave_model(arguments, run);
}

}  // namespace polhode::platform
