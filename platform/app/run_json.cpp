#include "app/run_json.hpp"

#include <nlohmann/json.hpp>

#include "app/checkpoint_writer.hpp"
#include "app/exposure_control.hpp"
#include "app/machine.hpp"
#include "app/motion_csv.hpp"
#include "output_file.hpp"

namespace polhode::platform {
namespace {

using Json = nlohmann::ordered_json;

Json durations(const DurationHistogram& h) {
  return {{"count", h.count()},
          {"mean", h.mean_us()},
          {"p50", h.percentile_us(0.5)},
          {"p95", h.percentile_us(0.95)},
          {"p99", h.percentile_us(0.99)},
          {"max", h.max_us()}};
}

Json camera_counts(const CameraCounters& c) {
  return {{"frames", c.frames},
          {"frames_damaged", c.frames_damaged},
          {"frames_missing", c.frames_missing},
          {"frames_late", c.frames_late},
          {"frames_out_of_time", c.frames_out_of_time},
          {"timeouts", c.timeouts},
          {"stream_errors", c.stream_errors},
          {"disconnects", c.disconnects},
          {"busy", c.busy},
          {"attempts", c.attempts},
          {"opened", c.opened}};
}

Json recording(Recorder* recorder) {
  if (recorder == nullptr) {
    return nullptr;
  }
  const RecorderCounters c = recorder->counters();
  return {{"frames", c.frames},
          {"missed", c.missed},
          {"write_failures", c.write_failures},
          {"octets", c.bytes}};
}

Json checkpoints(CheckpointWriter* writer) {
  if (writer == nullptr) {
    return nullptr;
  }
  const CheckpointCounters c = writer->counters();
  return {
      {"written", c.written}, {"failed", c.failed}, {"skipped", c.skipped}, {"octets", c.bytes}};
}

Json transports(const Transports& all) {
  Json addresses = Json::array();
  for (std::size_t i = 0; i < all.senders(); ++i) {
    const SendCounts& c = all.counts(i);
    addresses.push_back({{"address", all.address(i)},
                         {"sent", c.sent},
                         {"dropped", c.dropped},
                         {"without_reader", c.no_reader}});
  }
  const CommandCounts& commands = all.commands().guard().counts();
  return {{"send", addresses},
          {"commands_signed", all.commands().guard().has_key()},
          {"commands_received", commands.received},
          {"commands_passed", commands.passed},
          {"commands_refused",
           {{"sender", commands.refused_sender},
            {"form", commands.refused_form},
            {"mac", commands.refused_mac},
            {"number", commands.refused_number}}},
          {"commands_dropped", all.commands().dropped()}};
}

}  // namespace

void write_run_json(const std::filesystem::path& file, const RunJsonInput& input) {
  const LiveCounts& counts = input.parts.counts;
  const MachineUse use = machine_use();
  const bool pose = counts.frames_with_pose > 0;
  const Json run = {
      {"version", kVersion},
      {"config_hash", input.config_hash},
      {"start", input.beginning},
      {"mode", mode_name(input.parts.report.last().mode)},
      {"frames_accepted", counts.frames_accepted},
      {"frames_dropped_for_job", counts.frames_dropped_for_job},
      {"frames_with_pose", counts.frames_with_pose},
      {"first_pose_frame", pose ? Json(counts.first_pose_frame) : Json(nullptr)},
      {"camera", camera_counts(input.parts.camera.counters())},
      {"step_us", durations(counts.step)},
      {"publish_us", durations(counts.publish)},
      {"deadline",
       {{"allowed_us", counts.deadline.allowed_us()},
        {"missed", counts.deadline.missed()},
        {"missed_in_a_row_max", counts.deadline.missed_in_a_row_max()}}},
      {"exposure_changes", input.parts.exposure.changes()},
      {"latency_us", durations(counts.latency)},
      {"latency_cpu_us", durations(counts.latency_cpu)},
      {"outside_cpu_us", durations(counts.outside_cpu)},
      {"bus_octets", input.parts.packets == nullptr ? 0 : input.parts.packets->octets()},
      {"bus_write_failures", input.parts.packets == nullptr ? 0 : input.parts.packets->failures()},
      {"transport", transports(input.parts.transports)},
      {"recording", recording(input.parts.recorder)},
      {"checkpoints", checkpoints(input.parts.checkpoint)},
      {"peak_resident_octets", use.peak_resident_bytes},
      {"cpu_s", use.cpu_s}};
  write_file(file, run.dump(2) + "\n");
}

}  // namespace polhode::platform
