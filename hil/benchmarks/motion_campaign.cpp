// Many seeds of the dynamics' fit against the Cramer-Rao bound: bench_motion_campaign [SEEDS].
//
// A row for each number: error RMS over the bound, declared sigma over the error's RMS, part of the
// errors inside 1.96 sigma. Exit status 1 where a case misses what is asked of it.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>

#include "model_statistics.hpp"

namespace {

using polhode::BoundCase;
using polhode::Compared;
using polhode::kCompared;

struct NamedCase {
  const char* name;
  BoundCase bound;
};

std::array<NamedCase, 4> cases() {
  BoundCase paper{.body = polhode::paper_body(), .frames = 300, .interval_s = 10.0, .noise = {}};
  paper.body.inertia = {0.45, 0.47, 0.02};
  paper.body.mass_centre_T = {0.02, 0.01, -0.03};
  BoundCase young = paper;
  young.frames = 60;
  const BoundCase tumble{.body = polhode::asymmetric_body(3.0 * polhode::kDegree_rad),
                         .frames = 150,
                         .interval_s = 2.0,
                         .noise = {}};
  BoundCase fast{.body = polhode::asymmetric_body(5.0 * polhode::kDegree_rad),
                 .frames = 300,
                 .interval_s = 1.0,
                 .noise = {}};
  fast.body.mass_centre_T = {0.05, -0.035, 0.08};
  return {{{"paper, 300 frames", paper},
           {"paper, first 60", young},
           {"tumble, 150 frames", tumble},
           {"fast tumble, 300 frames", fast}}};
}

constexpr std::array<const char*, kCompared> kNames{"attitude x",
                                                    "attitude y",
                                                    "attitude z",
                                                    "rate x",
                                                    "rate y",
                                                    "rate z",
                                                    "velocity x",
                                                    "velocity y",
                                                    "velocity z",
                                                    "mass centre x",
                                                    "mass centre y",
                                                    "mass centre z",
                                                    "ln J2/J1",
                                                    "ln J3/J1"};

bool report(const NamedCase& c, int seeds) {
  const polhode::ModelStatistics s = polhode::run_seeds(c.bound, seeds);
  const Compared bound = polhode::cramer_rao(c.bound);
  std::printf("%s: %d of %d accepted\n", c.name, s.accepted, s.seeds);
  std::printf("  %-14s %12s %12s %10s %10s %8s\n",
              "",
              "bound",
              "error RMS",
              "RMS/bound",
              "sigma/RMS",
              "inside");
  double inside = 0.0;
  bool good = s.accepted >= 0.95 * s.seeds;
  for (int k = 0; k < kCompared; ++k) {
    std::printf("  %-14s %12.3e %12.3e %10.2f %10.2f %7.0f%%\n",
                kNames[static_cast<std::size_t>(k)],
                bound(k),
                s.rms(k),
                s.rms(k) / bound(k),
                s.sigma(k) / s.rms(k),
                100.0 * s.inside(k));
    inside += s.inside(k) / kCompared;
    good = good && s.rms(k) < 2.0 * bound(k) && s.sigma(k) < 10.0 * s.rms(k);
  }
  std::printf("  inside on average %.1f %%\n", 100.0 * inside);
  return good && inside > 0.93;
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 50;
  bool good = true;
  for (const NamedCase& c : cases()) {
    good = report(c, std::max(1, seeds)) && good;
  }
  return good ? 0 : 1;
}
