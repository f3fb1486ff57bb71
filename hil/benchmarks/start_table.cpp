// How often each way to start a map finds the right geometry: cylinder 0.4 m high and 0.3 m across,
// 70 to 115 points seen in all 8 frames, 0.5 px noise, f = 2667 px, random first attitude, constant
// turn about an axis within 30 deg of the image plane, 2 % change of range; alpha is the angle that
// the height subtends. Usage: bench_start_table [trials] [frames] [first seed].
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <numbers>
#include <string>

#include "synthetic/initial_problem.hpp"

namespace {

using namespace polhode;

constexpr double kDegree = std::numbers::pi / 180.0;

struct Trial {
  synthetic::Motion motion;
  std::vector<synthetic::Track> tracks;
};

Trial make_trial(double alpha_deg, double turn_deg, int frames, std::uint64_t seed) {
  Rng rng(seed, 1);
  const double range_m = 0.4 / (alpha_deg * kDegree);
  const synthetic::Body body = synthetic::cylinder(700, 0.15, 0.4, &rng);
  const double change = (rng.uniform() < 0.5 ? -0.02 : 0.02) * range_m;
  synthetic::ConstantTurn turn{.frames = frames, .turn_rad = turn_deg * kDegree};
  turn.axis_C = synthetic::direction_near_image_plane(30.0 * kDegree, &rng);
  turn.R_first = synthetic::random_attitude(&rng);
  turn.p_first_m = {0.0, 0.0, range_m};
  turn.p_last_m = {0.0, 0.0, range_m + change};
  Trial trial;
  trial.motion = synthetic::constant_turn(turn, &rng);
  const int count = 70 + static_cast<int>(rng.below(46));
  trial.tracks = synthetic::track_points(
      body, trial.motion, {.all_frames_only = true, .tracks_max = count}, &rng);
  return trial;
}

struct Cell {
  int right = 0;
  int commits_right = 0;
  int commits_wrong = 0;
  double seconds = 0.0;
};

Cell run_cell(double alpha_deg,
              double turn_deg,
              int frames,
              int trials,
              std::uint64_t first_seed,
              std::uint32_t kinds,
              InitialWorkspace* workspace) {
  Cell cell;
  for (int i = 0; i < trials; ++i) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i) +
                               static_cast<std::uint64_t>(1e6 * alpha_deg + 1e3 * turn_deg);
    const Trial trial = make_trial(alpha_deg, turn_deg, frames, seed);
    const std::vector<InitialTrack> tracks = synthetic::to_start_tracks(trial.tracks, 0.5 / 2667.0);
    const InitialProblem problem{
        .times_s = trial.motion.times_s, .tracks = tracks, .seed = seed, .kinds = kinds};
    const std::clock_t begin = std::clock();
    const InitialOutcome out = select_hypothesis(problem, InitialOptions{}, workspace);
    cell.seconds += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    const bool right = synthetic::compare_start(out, trial.tracks, trial.motion).right();
    cell.right += right ? 1 : 0;
    if (out.decision == InitialDecision::kCommit) {
      ++(right ? cell.commits_right : cell.commits_wrong);
      if (!right) {
        const synthetic::InitialErrors e =
            synthetic::compare_start(out, trial.tracks, trial.motion);
        std::printf(
            "  wrong commit: alpha %.1f turn %.0f seed %llu gap %.1f depth %.2f rotation %.2f "
            "sigma %.3f\n",
            alpha_deg,
            turn_deg,
            static_cast<unsigned long long>(seed),
            out.chi2_margin,
            e.depth,
            e.rotation,
            out.selection_depth_sigma);
      }
    }
  }
  return cell;
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 16;
  const int frames = argc > 2 ? std::atoi(argv[2]) : 8;
  const std::uint64_t first_seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  const bool singles = argc <= 4;
  const auto workspace = std::make_unique<InitialWorkspace>();
  struct Column {
    const char* name;
    std::uint32_t kinds;
  };
  const Column columns[] = {{"contest", kAllKinds},
                            {"five-point", kind_bit(HypothesisKind::kFivePoint)},
                            {"homography", kind_bit(HypothesisKind::kHomography)},
                            {"factorisation", kind_bit(HypothesisKind::kFactorisation)},
                            {"constant rate", kind_bit(HypothesisKind::kConstantRate)}};
  std::printf("%d trials a cell, %d frames; right in %% [commits right/wrong]\n", trials, frames);
  std::printf("%-6s %-5s", "alpha", "turn");
  for (const Column& column : columns) {
    std::printf("  %-22s", column.name);
    if (!singles) {
      break;
    }
  }
  std::printf("\n");
  for (const double alpha_deg : {1.5, 3.0, 6.0, 12.0}) {
    for (const double turn_deg : {10.0, 20.0, 45.0}) {
      std::string line;
      for (const Column& column : columns) {
        const Cell cell = run_cell(
            alpha_deg, turn_deg, frames, trials, first_seed, column.kinds, workspace.get());
        char text[64];
        std::snprintf(text,
                      sizeof text,
                      "%3.0f [%3d/%d] %4.0f ms      ",
                      100.0 * cell.right / trials,
                      cell.commits_right,
                      cell.commits_wrong,
                      1e3 * cell.seconds / trials);
        line += text;
        if (!singles) {
          break;
        }
      }
      std::printf("%-6.1f %-5.0f  %s\n", alpha_deg, turn_deg, line.c_str());
      std::fflush(stdout);
    }
  }
  return 0;
}
