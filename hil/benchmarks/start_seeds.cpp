// Many seeds of each family of starts: how often a map is begun, and how often wrongly. Prints the
// seed of every wrong one. Usage: bench_start_seeds [seeds] [first seed] [family]. Exit status 1
// when a wrong start was committed.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>

#include "synthetic/initial_scenarios.hpp"

namespace {

using namespace polhode;

struct Tally {
  int commits = 0;
  int right = 0;
  int poor = 0;   // depth or turn off by 25 to 50 %
  int wrong = 0;  // more: a wrong twin, or no body at all
  std::array<int, 5> decisions{};
  double seconds = 0.0;
  double seconds_max = 0.0;
};

void judge(const InitialOutcome& out,
           const synthetic::InitialScenario& s,
           const char* name,
           std::uint64_t seed,
           bool has_body,
           Tally* tally) {
  ++tally->decisions[static_cast<std::size_t>(out.decision)];
  if (out.decision != InitialDecision::kCommit) {
    return;
  }
  ++tally->commits;
  // The turn of a body that only drifts is compared by its depths alone.
  synthetic::InitialErrors e = synthetic::compare_start(out, s.tracks, s.motion);
  if (rotation_angle_rad(s.motion.poses.front().R_CT, s.motion.poses.back().R_CT) < 0.05) {
    e.rotation = 0.0;
  }
  if (has_body && e.right()) {
    ++tally->right;
    return;
  }
  const bool poor = has_body && e.depth < 0.5 && e.rotation < 0.5;
  ++(poor ? tally->poor : tally->wrong);
  std::printf(
      "  %s %s seed %llu: gap %.1f depth %.2f turn %.2f sigma %.3f chi2 %.2f inliers %.2f\n",
      poor ? "poor" : "WRONG",
      name,
      static_cast<unsigned long long>(seed),
      out.chi2_margin,
      e.depth,
      e.rotation,
      out.selection_depth_sigma,
      out.reduced_chi2,
      out.inlier_ratio);
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 100;
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  const int only = argc > 3 ? std::atoi(argv[3]) : -1;
  const auto workspace = std::make_unique<InitialWorkspace>();
  int wrong = 0;
  for (std::size_t k = 0; k < synthetic::kInitialFamilies.size(); ++k) {
    if (only >= 0 && static_cast<std::size_t>(only) != k) {
      continue;
    }
    Tally tally;
    const synthetic::InitialFamily family = synthetic::kInitialFamilies[k];
    for (int i = 0; i < seeds; ++i) {
      const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
      const synthetic::InitialScenario s = synthetic::make_initial_scenario(family, seed);
      const std::vector<InitialTrack> tracks =
          synthetic::to_start_tracks(s.tracks, s.sigma_normalised);
      const std::clock_t begin = std::clock();
      const InitialOutcome out =
          select_hypothesis({.times_s = s.motion.times_s, .tracks = tracks, .seed = seed},
                            InitialOptions{},
                            workspace.get());
      const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
      tally.seconds += seconds;
      tally.seconds_max = std::max(tally.seconds_max, seconds);
      judge(out, s, synthetic::kInitialFamilyNames[k], seed, synthetic::has_body(family), &tally);
    }
    wrong += tally.wrong;
    std::printf(
        "%-12s commits %4d of %4d: right %4d poor %3d wrong %3d | waits: few tracks %d, no "
        "hypothesis %d, "
        "little motion %d, twins %d | %.0f ms, at most %.0f\n",
        synthetic::kInitialFamilyNames[k],
        tally.commits,
        seeds,
        tally.right,
        tally.poor,
        tally.wrong,
        tally.decisions[1],
        tally.decisions[2],
        tally.decisions[3],
        tally.decisions[4],
        1e3 * tally.seconds / seeds,
        1e3 * tally.seconds_max);
    std::fflush(stdout);
  }
  return wrong == 0 ? 0 : 1;
}
