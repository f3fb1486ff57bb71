"""The three budgets: builds what they need, replays the sample with each, and sets memory and accuracy beside the default's.

    tools/check_budgets.py [--seeds 1 2 3 4 5 6 7]

Exit status 1: one of them does not run, takes more memory than it says, or is less accurate than 1.5 times the default. Errors
are medians over the seeds: a single run's vary by a factor of two. Takes some minutes, and a build of the small program.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from polhode_ground.common.venv import REPOSITORY

SAMPLE = REPOSITORY / "hil/data/sample"
WORSE_MAX = 1.5
# Configuration, and the build that runs it.
BUDGETS = {"default": "release", "small": "small", "standard": "release", "full": "release"}
MEASURES = {
    "causal attitude [deg]": ("causal", "attitude", "rmse_deg"),
    "smoothed attitude [deg]": ("smoothed", "attitude", "rmse_deg"),
    "causal position [% of range]": ("causal", "position", "rmse_percent_of_range"),
    "smoothed position [% of range]": ("smoothed", "position", "rmse_percent_of_range"),
}


def build(preset: str) -> None:
    subprocess.run(["cmake", "--preset", preset], cwd=REPOSITORY, check=True, capture_output=True)
    subprocess.run(["cmake", "--build", "--preset", preset, "--target", "polhode"], cwd=REPOSITORY, check=True, capture_output=True)


def replay(budget: str, seed: int, folder: Path) -> dict:
    """What it took and what came out. @return octets resident at most, octets planned, and the measures."""
    program = REPOSITORY / f"build/{BUDGETS[budget]}/bin/polhode"
    subprocess.run(
        [
            program,
            "replay",
            "--config",
            REPOSITORY / f"config/{budget}.toml",
            "--sequence",
            SAMPLE,
            "--out",
            folder,
            "--set",
            f"seed={seed}",
        ],
        check=True,
        capture_output=True,
    )
    report = folder / "judgement.json"
    subprocess.run([sys.executable, REPOSITORY / "hil/evaluate.py", folder, SAMPLE, "--json", report], check=True, capture_output=True)
    motion = json.loads(report.read_text())["runs"][0]["motion"]
    memory = json.loads((folder / "summary.json").read_text())["memory"]
    found = {name: motion[a][b][c] for name, (a, b, c) in MEASURES.items()}
    # What follows the last frame is the ground's work.
    return {
        "resident": memory["components"]["peak_resident_after_last_frame_octets"],
        "allowed": memory["budget_octets"],
        "overdrawn": memory["pools"]["reserve"]["peak_octets"],
        **found,
    }


def verdicts(budget: str, found: dict[str, float], default: dict[str, float]) -> list[str]:
    """One line for each promise that is not kept."""
    wrong = [
        f"{budget}: {name} {found[name]:.3f}, the default reaches {default[name]:.3f}"
        for name in MEASURES
        if found[name] > WORSE_MAX * default[name]
    ]
    if found["resident"] > found["allowed"]:
        wrong.append(f"{budget}: {found['resident']} octets resident, {found['allowed']} allowed")
    if found["overdrawn"] > 0:
        wrong.append(f"{budget}: drew {found['overdrawn']} octets of the reserve")
    return wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5, 6, 7])
    seeds = parser.parse_args().seeds
    for preset in sorted(set(BUDGETS.values())):
        build(preset)
    found = {}
    with tempfile.TemporaryDirectory() as scratch:
        for budget in BUDGETS:
            runs = [replay(budget, seed, Path(scratch) / f"{budget}-{seed}") for seed in seeds]
            found[budget] = {key: statistics.median(run[key] for run in runs) for key in runs[0]}
            found[budget]["resident"] = max(run["resident"] for run in runs)
            print(
                f"{budget:<10} {found[budget]['resident'] / 2**20:6.1f} of {found[budget]['allowed'] / 2**20:.0f} MiB   "
                + "   ".join(f"{name} {found[budget][name]:.3f}" for name in MEASURES),
                flush=True,
            )
    wrong = [line for budget in BUDGETS for line in verdicts(budget, found[budget], found["default"])]
    print("\n".join(wrong) or "all promises are kept")
    return 1 if wrong else 0


def command() -> None:
    sys.exit(main())
