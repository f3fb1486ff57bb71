#include "app/summary.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "app/camera_check.hpp"
#include "app/motion_csv.hpp"
#include "bus/counter_table.hpp"
#include "output_file.hpp"
#include "quote.hpp"

namespace polhode::platform {
namespace {

using Json = nlohmann::ordered_json;

void add_percentiles(const char* clock, const Durations& d, Json* out) {
  for (const auto& [name, fraction] :
       {std::pair("p50_us", 0.50), {"p95_us", 0.95}, {"p99_us", 0.99}, {"max_us", 1.0}}) {
    (*out)[fmt::format("{}{}", clock, name)] = d.percentile_us(fraction);
  }
}

Json durations(const Durations& d) {
  Json out{{"count", d.samples_us.size()}};
  add_percentiles("", d, &out);
  return out;
}

/// With the processor time of the thread that steps.
Json durations(const Durations& wall, const Durations& cpu) {
  Json out = durations(wall);
  add_percentiles("cpu_", cpu, &out);
  return out;
}

Json timings(const SummaryInput& input) {
  const Timings& t = input.timings;
  Json out{{"read", durations(t.read)},
           {"step", durations(t.step, t.step_cpu)},
           {"job", durations(t.job)}};
  for (std::size_t i = 0; i < kStageCount; ++i) {
    out[stage_name(static_cast<Stage>(i))] = durations(t.stages[i], t.stages_cpu[i]);
  }
  return out;
}

Json counters(const Counters& c) {
  Json out;
  for (const bus::CounterRow& row : bus::kCounters) {
    out[row.name] = c.*row.counted;
  }
  return out;
}

Json mode_history(const RunRecord& record) {
  Json out = Json::array();
  for (const ModeChange& change : record.mode_changes) {
    out.push_back({{"frame", change.frame},
                   {"timestamp_ns", change.timestamp_ns},
                   {"mode", mode_name(change.mode)}});
  }
  return out;
}

Json bad_frames(const RunRecord& record) {
  Json out = Json::array();
  for (const BadFrame& bad : record.bad_frames) {
    Json entry{
        {"frame", bad.frame}, {"timestamp_ns", bad.timestamp_ns}, {"use", use_name(bad.use)}};
    if (bad.verdict.fault != FrameFault::kNone) {
      entry["fault"] = fault_name(bad.verdict.fault);
      entry["measure"] = bad.verdict.measure;
      entry["limit"] = bad.verdict.limit;
    }
    if (!bad.reason.empty()) {
      entry["reason"] = bad.reason;
    }
    out.push_back(std::move(entry));
  }
  return out;
}

Json memory(const SummaryInput& input) {
  Json pools = Json::object();
  for (std::size_t i = 0; i < kPoolCount; ++i) {
    const HeapUse& use = input.pools[i];
    pools[pool_name(static_cast<Pool>(i))] = {{"octets", use.total_bytes},
                                              {"peak_octets", use.peak_bytes},
                                              {"at_end_octets", use.used_bytes},
                                              {"live_blocks", use.live_blocks}};
  }
  return {{"budget_octets", input.plan.limit_bytes},
          {"planned_octets", input.plan.total_bytes},
          {"fixed", memory_is_fixed()},
          {"peak_resident_octets", input.at_end.peak_resident_bytes},
          {"pools", pools},
          {"components",
           {{"component_tables_octets", input.plan.tables_bytes},
            {"grown_beyond_pools_octets", grown_bytes()},
            {"peak_resident_before_first_frame_octets", input.at_start.peak_resident_bytes},
            {"peak_resident_after_last_frame_octets", input.after_frames.peak_resident_bytes}}}};
}

/// Memory before the first frame, and at the end.
Json warnings(const SummaryInput& input) {
  Json out = input.sequence.warnings;
  for (const std::string& remark : input.remarks) {
    out.push_back(remark);
  }
  for (const std::string& sentence :
       camera_sentences(input.record.camera.found, to_model(input.sequence.camera))) {
    out.push_back(sentence);
  }
  return out;
}

/// Further inputs that determine the packets.
Json own_structure(const OwnStructureFile& own) {
  return own.present() ? Json{{"sha256", own.sha256()}, {"part_of_picture", own.part()}} : Json();
}

/// Each deviation as fitted beside the contradicted ones; null where there was no test.
Json deviations(const CameraReport& report) {
  constexpr std::array<const char*, kDeviations> kNames = {"log_focal_length",
                                                           "log_zoom",
                                                           "log_fv_over_fu",
                                                           "principal_u_over_fu",
                                                           "principal_v_over_fv",
                                                           "readout_s",
                                                           "upper_half_older_s"};
  Json out = Json::object();
  for (std::size_t i = 0; i < kDeviations; ++i) {
    const auto deviation = static_cast<Deviation>(i);
    const bool known = report.fit.usable || report.found.is(deviation);
    out[kNames[i]] = known ? Json{{"off_by", report.found.of(deviation)},
                                  {"sigma", report.found.sigma_of(deviation)},
                                  {"contradicted", report.found.is(deviation)}}
                           : Json();
  }
  return out;
}

Json cost(const SummaryInput& input) {
  const auto frames = static_cast<double>(input.record.frames_in);
  const double cpu_s = input.after_frames.cpu_s - input.at_start.cpu_s;
  return {{"wall_s", input.wall_s},
          {"cpu_s", cpu_s},
          {"cpu_per_frame_s", cpu_s / frames},
          {"frames_per_s", frames / input.wall_s},
          {"finish_wall_s", input.finish_s},
          {"finish_cpu_s", input.at_end.cpu_s - input.after_frames.cpu_s}};
}

/// As given, and by the converged map; only the first where the map does not determine it.
Json focal_length(const CameraReport& report, const CameraParameters& camera) {
  const double given_px = std::sqrt(camera.fu_px * camera.fv_px);
  Json out{{"given_px", given_px}, {"found_px", Json()}, {"sigma_px", Json()}};
  if (report.fit.usable || report.found.is(Deviation::kFocal)) {
    const double found_px = given_px * std::exp(report.found.of(Deviation::kFocal));
    out["found_px"] = found_px;
    out["sigma_px"] = found_px * report.found.sigma_of(Deviation::kFocal);
  }
  if (report.fit.usable) {
    const auto observations = static_cast<double>(report.fit.observations);
    out["cost_as_given"] = report.fit.cost_as_given / observations;
    out["cost_as_found"] = report.fit.cost_as_found / observations;
  }
  out["refuted"] = report.found.is(Deviation::kFocal);
  return out;
}

constexpr const char* kPathHere = "PATH";

double norm(const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

}  // namespace

std::string result_sentence(const RunRecord& record,
                            const Counters& counters,
                            const CameraParameters& camera) {
  if (!record.first_pose_frame) {
    return fmt::format(
        "The target was never {}: {} frames, {} of them usable, none with a pose; {} at the end.",
        !record.model.empty() ? "recognised by its model nor acquired anew" : "acquired",
        record.frames_in,
        counters.frames_used,
        mode_name(record.last.mode));
  }
  std::string text = fmt::format(
      "The target was {}: poses on {} of {} frames, the first on frame {}; {} at the end",
      record.model.empty()    ? "acquired"
      : is_recognised(record) ? "recognised by its model"
                              : "not recognised by its model, and acquired anew",
      record.frames_with_pose,
      record.frames_in,
      *record.first_pose_frame,
      mode_name(record.last.mode));
  if (record.last.rate_valid) {
    text += fmt::format(", turning at {:.3f} deg/s",
                        norm(record.last.w_T_rad_s) * 180.0 / std::numbers::pi);
  }
  if (record.last.velocity_valid) {
    text += fmt::format(", moving at {:.4g} {}/s",
                        norm(record.last.v_C),
                        record.last.scale_known ? "m" : "map units");
  }
  text += ".";
  for (const std::string& warning : camera_sentences(record.camera.found, to_model(camera))) {
    text += " " + warning;
  }
  return text;
}

void write_summary(const std::filesystem::path& file, const SummaryInput& input) {
  const RunRecord& record = input.record;
  Json frames{{"in", record.frames_in},
              {"processed", input.counters.frames_used},
              {"with_pose", record.frames_with_pose}};
  frames["first_with_pose"] = record.first_pose_frame ? Json(*record.first_pose_frame) : Json();
  const Json summary{
      {"program", "polhode"},
      {"version", kVersion},
      {"result", result_sentence(record, input.counters, input.sequence.camera)},
      {"acquired", record.first_pose_frame.has_value()},
      {"model",
       record.model.empty() ? Json()
                            : Json{{"file", record.model}, {"recognised", is_recognised(record)}}},
      {"warnings", warnings(input)},
      {"focal_length", focal_length(record.camera, input.sequence.camera)},
      {"camera", deviations(record.camera)},
      {"mode_at_end", mode_name(record.last.mode)},
      {"sequence", kPathHere},
      {"depth_bits", input.sequence.depth_bits},
      {"mosaic", input.sequence.mosaic},
      {"config_hash", input.config_hash},
      {"own_structure", own_structure(input.own)},
      {"frames", frames},
      {"mode_changes", record.mode_changes_total},
      {"mode_history", mode_history(record)},
      {"bad_frames", bad_frames(record)},
      {"counters", counters(input.counters)},
      {"timings", timings(input)},
      {"memory", memory(input)},
      {"cost", cost(input)},
      {"deadline",
       {{"frame_us", input.deadline.allowed_us()},
        {"missed", input.deadline.missed()},
        {"missed_in_a_row", input.deadline.missed_in_a_row_max()},
        {"worst_us", input.deadline.worst_us()}}},
      {"bus", {{"octets", input.bus_octets}, {"sha256", input.bus_sha256}}},
      {"bus_sha256", input.bus_sha256}};
  // Texts may cite any bytes; what is not UTF-8 is replaced rather than refused. The path alone is
  // to be found again by it.
  std::string text = summary.dump(2, ' ', false, Json::error_handler_t::replace);
  const std::string place = fmt::format("\"sequence\": \"{}\"", kPathHere);
  text.replace(
      text.find(place), place.size(), "\"sequence\": " + json_text(input.sequence.path.string()));
  write_file(file, text + "\n");
}

}  // namespace polhode::platform
