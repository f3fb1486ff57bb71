// From which frame on could a sequence's images decide on the depth sign? The component follows its
// tracks through the sequence without ever beginning a map, and each selection that it would make
// is judged by the truth (decidability.hpp).
//   start_limit --config config/default.toml --sequence SEQ [--set key=value ...] [--json FILE]
// A frame counts as decidable when the expected margin reaches start.chi2_gap_commit. JSON: `frame`
// and `turn_deg` of the first such frame, null where there is none, and a row a frame.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "app/component_memory.hpp"
#include "camera/replay/file_camera.hpp"
#include "decidability.hpp"
#include "errors.hpp"
#include "geometry/so3.hpp"
#include "initialisation/collect.hpp"
#include "initialisation/initialisation_job.hpp"
#include "parameters/load.hpp"
#include "pipeline/ground_view.hpp"
#include "true_frames.hpp"

namespace {

using namespace polhode;
using namespace polhode::benchmark;

struct Row {
  std::size_t frame = 0;
  double turn_deg = 0.0;   ///< of the body as the camera sees it, all turns since the first frame
  std::size_t frames = 0;  ///< of the selection
  Decidability found;
};

/// Turns between frames added up, by time stamp.
std::map<std::int64_t, double> turns_deg(const std::map<std::int64_t, Pose>& truth) {
  std::map<std::int64_t, double> turns;
  double sum_rad = 0.0;
  const Pose* before = nullptr;
  for (const auto& [timestamp_ns, pose] : truth) {
    sum_rad += before == nullptr ? 0.0 : rotation_angle_rad(before->R_CT, pose.R_CT);
    turns[timestamp_ns] = sum_rad * 180.0 / std::numbers::pi;
    before = &pose;
  }
  return turns;
}

/// The better of the two selections that the component alternates between.
std::optional<Row> judge(const std::map<std::int64_t, Pose>& truth,
                         const CameraModel& camera,
                         const InitialOptions& options,
                         InitialisationState* tracks,
                         InitialisationJob* job) {
  std::optional<Row> best;
  for (int which = 0; which < 2; ++which) {
    pose_problem(camera, options, 1, tracks, job);
    std::vector<Pose> poses;
    for (std::size_t f = 0; f < job->frame_count; ++f) {
      const auto at = truth.find(tracks->tracks.frames[job->first_frame + f].timestamp_ns);
      if (at == truth.end()) {
        return best;
      }
      poses.push_back(at->second);
    }
    const InitialProblem problem{.times_s = std::span(job->times_s).first(job->frame_count),
                                 .tracks = std::span(job->tracks).first(job->track_count),
                                 .seed = job->seed};
    const Decidability found = decide_by_truth(problem, poses, &job->workspace);
    if (found.known && (!best || found.margin > best->found.margin)) {
      best = Row{.frames = job->frame_count, .found = found};
    }
  }
  return best;
}

std::vector<Row> follow(const std::string& config,
                        const platform::Sequence& sequence,
                        const std::map<std::int64_t, Pose>& truth,
                        Parameters parameters) {
  const InitialOptions options = parameters.start;
  // Jobs are handed out, and come back without a result: no map ever begins, and tracks go on.
  parameters.jobs.delay_frames = 1;
  parameters.camera = sequence.camera;
  platform::ComponentMemory memory(parameters, config, {});
  Result<Component*> made = Component::create(memory.span(), parameters);
  Component& component = *made.value();
  const GroundView view = view_of(component);
  const auto job = std::make_unique<InitialisationJob>();
  const auto copy = std::make_unique<InitialisationState>();
  const auto turns = turns_deg(truth);
  platform::FileCamera camera(sequence);
  Jobs waiting;
  Frame frame;
  std::vector<Row> rows;
  while (camera.next(frame)) {
    const StepOutput& out = component.step({.frame = frame, .finished = waiting});
    waiting.clear();
    for (Job* asked : out.jobs) {
      skip_job(*asked);
      (void)waiting.push_back(asked);
    }
    const TrackTable& tracks = view.initialisation.tracks;
    const bool kept =
        !tracks.frames.empty() && tracks.frames.back().timestamp_ns == frame.timestamp_ns;
    if (!kept || static_cast<int>(tracks.frames.size()) < options.frames_min) {
      continue;
    }
    *copy = view.initialisation;
    if (std::optional<Row> row = judge(truth, view.camera, options, copy.get(), job.get())) {
      row->frame = camera.index();
      row->turn_deg = turns.at(frame.timestamp_ns);
      rows.push_back(*row);
    }
  }
  Component::destroy(&component);
  return rows;
}

void write_json(const std::string& file, const std::vector<Row>& rows, const Row* limit) {
  std::ofstream out(file);
  out << (limit == nullptr ? std::string("{\"frame\": null, \"turn_deg\": null, \"rows\": [")
                           : fmt::format("{{\"frame\": {}, \"turn_deg\": {:.3f}, \"rows\": [",
                                         limit->frame,
                                         limit->turn_deg));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out << fmt::format(
        "{}{{\"frame\": {}, \"turn_deg\": {:.3f}, \"frames\": {}, \"tracks\": {}, \"noise\": "
        "{:.3f}, \"margin\": {:.2f}}}",
        i > 0 ? ", " : "",
        rows[i].frame,
        rows[i].turn_deg,
        rows[i].frames,
        rows[i].found.tracks,
        rows[i].found.noise,
        rows[i].found.margin);
  }
  out << "]}\n";
  out.flush();
  if (!out) {
    throw platform::RunFailure("start_limit: cannot write " + file);
  }
}

int run(int argc, char** argv) {
  std::string config;
  std::string folder;
  std::string json;
  std::vector<std::string> settings;
  CLI::App app{"From which frame on a sequence's images could decide on the depth sign"};
  app.add_option("--config", config)->required();
  app.add_option("--sequence", folder, "with truth.csv")->required();
  app.add_option("--set", settings, "key=value");
  app.add_option("--json", json, "also written to this file");
  CLI11_PARSE(app, argc, argv);
  const platform::Configuration configuration = platform::load_configuration(config, settings);
  const platform::Sequence sequence = platform::open_sequence(folder);
  const std::vector<Row> rows =
      follow(config, sequence, read_truth(folder + "/truth.csv"), configuration.parameters);
  fmt::print("{:>6} {:>9} {:>7} {:>7} {:>9} {:>6} {:>9}\n",
             "frame",
             "turn [deg]",
             "frames",
             "tracks",
             "agree [%]",
             "noise",
             "margin");
  const Row* limit = nullptr;
  for (const Row& row : rows) {
    fmt::print("{:>6} {:>9.1f} {:>7} {:>7} {:>9.0f} {:>6.2f} {:>9.1f}\n",
               row.frame,
               row.turn_deg,
               row.frames,
               row.found.tracks,
               100.0 * row.found.agreeing,
               row.found.noise,
               row.found.margin);
    if (limit == nullptr && row.found.margin >= configuration.parameters.start.chi2_gap_commit) {
      limit = &row;
    }
  }
  if (limit == nullptr) {
    fmt::print("not decidable in {} frames\n", sequence.frames.size());
  } else {
    fmt::print(
        "decidable from frame {} on, after a turn of {:.1f} deg\n", limit->frame, limit->turn_deg);
  }
  if (!json.empty()) {
    write_json(json, rows, limit);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const platform::UnusableInput& problem) {
    fmt::print(stderr, "start_limit: {}\n", problem.what());
    return 2;
  } catch (const std::exception& problem) {
    fmt::print(stderr, "start_limit: {}\n", problem.what());
    return 1;
  }
}
