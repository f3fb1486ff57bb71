"""Runs a campaign: renders a plan's scenes, transforms and replays them, judges every run, and writes one report.

Whatever is done stays done: the same command after an interruption, or with a new program or judge, does what is missing
and nothing else. DIR/report/index.html holds the results so far while the campaign runs.

Examples:
  hil/campaign.py hil/campaigns/standing.toml --out DIR
  hil/campaign.py hil/campaigns/standing.toml --out NEW --vs DIR
  hil/campaign.py PLAN.toml --check
  hil/campaign.py --report DIR
"""

import argparse
import os
import pathlib
import subprocess
import sys
from typing import TYPE_CHECKING

from polhode_ground.common.ranges import number, whole
from polhode_ground.common.venv import REPOSITORY, enter_venv, run_main

if TYPE_CHECKING:
    from polhode_ground.campaigns.tasks import Outcome

FAILED, SCHEDULER_LOST, INTERRUPTED = 1, 1, 130


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 all is done, 1 some tasks failed or the scheduler was lost (run the same command again), 2 unusable input,\n"
        "130 interrupted.\n"
        "hil/campaigns/README.md describes plans; hil/campaigns/standing.toml is the standing set.",
    )
    parser.add_argument("plan", metavar="PLAN.toml", type=pathlib.Path, nargs="?")
    parser.add_argument("--out", metavar="DIR", type=pathlib.Path, help="folder of the campaign: runs, results, report")
    parser.add_argument(
        "--program",
        metavar="FILE",
        type=pathlib.Path,
        default=REPOSITORY / "build/release/bin/polhode",
        help="the program to run (default: build/release/bin/polhode)",
    )
    parser.add_argument("--vs", metavar="DIR2", type=pathlib.Path, help="another campaign's folder, for paired differences")
    parser.add_argument("--report", metavar="DIR", type=pathlib.Path, help="only write the report of what is done in DIR so far")
    parser.add_argument("--workers", type=whole(1, 1024), default=os.cpu_count(), help="on this machine (default: as many as cores)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="use the workers of a Dask scheduler, as tcp://host:8786")
    parser.add_argument(
        "--slurm", metavar="FILE.toml", type=pathlib.Path, help="use SLURM jobs as workers (hil/campaigns/slurm_example.toml)"
    )
    parser.add_argument("--cache", metavar="DIR", type=pathlib.Path, help="scenes (default: $POLHODE_CACHE/campaigns)")
    parser.add_argument("--report-every", metavar="S", type=number(1.0, 86400.0), default=60.0, help="seconds between reports (default 60)")
    parser.add_argument("--check", action="store_true", help="read the plan, list its runs, do nothing")
    return parser.parse_args()


def install_missing() -> None:
    """What only campaigns need stands in requirements of its own; set up on first use."""
    import importlib.util

    if any(importlib.util.find_spec(name) is None for name in ("distributed", "pyarrow", "dask_jobqueue")):
        print("campaign: installing what it needs: tools/setup.sh campaign", file=sys.stderr)
        if subprocess.run([REPOSITORY / "tools/setup.sh", "campaign"], stdout=sys.stderr).returncode != 0:
            sys.exit("campaign: tools/setup.sh campaign failed")


class Reporter:
    """Writes the report now and then while the campaign runs."""

    def __init__(self, out: pathlib.Path, every_s: float):
        import time

        self.out, self.every_s, self.clock = out, every_s, time.monotonic
        self.last_s = self.clock()

    def __call__(self, outcome: "Outcome") -> None:
        from polhode_ground.campaigns.report import write_report

        if outcome.task.kind == "judge" and self.clock() - self.last_s > self.every_s:
            try:
                write_report(self.out, pictures=False)
            except OSError as problem:  # the campaign goes on; the last report counts
                print(f"campaign: no report for now: {problem}", file=sys.stderr)
            self.last_s = self.clock()


def run_campaign(options: argparse.Namespace) -> int:
    from polhode_ground.campaigns import cluster, execution
    from polhode_ground.campaigns.book import open_book, read_book
    from polhode_ground.campaigns.plan import read_plan
    from polhode_ground.campaigns.report import write_report
    from polhode_ground.campaigns.store import Store
    from polhode_ground.common.replay import cache_folder

    plan = read_plan(options.plan)
    if options.check:
        print(
            f"{options.plan}: {len(plan.scenes)} scenes x {len(plan.transforms)} transforms x {len(plan.settings)} settings = {len(plan.runs)} runs"
        )
        print("\n".join(run.name for run in plan.runs))
        return 0
    if options.vs is not None:
        read_book(options.vs)  # refused now, not after the work
    out = options.out.resolve()
    chains = open_book(plan, Store(out, (options.cache or cache_folder("campaigns")).resolve()), options.program)
    try:
        with cluster.workers(options.workers, options.scheduler, options.slurm) as client:
            outcomes = execution.execute(client, chains, out, plan.time_alone, Reporter(out, options.report_every))
    except execution.SchedulerLost as problem:
        print(f"campaign: the scheduler is gone ({problem}); what was finished is kept: run the same command again", file=sys.stderr)
        return SCHEDULER_LOST
    except KeyboardInterrupt:
        print("campaign: interrupted; what was finished is kept: run the same command again", file=sys.stderr)
        return INTERRUPTED
    page, figures = write_report(out, options.vs)
    print(figures)
    failed = [one for one in outcomes if not one.ok]
    waiting = sum(one.not_tried for one in failed)
    for one in failed:
        if not one.not_tried:
            print(
                f"campaign: {one.task.kind} of {one.task.name} failed: {one.why}" + (f" ({one.task.log})" if one.task.log.exists() else ""),
                file=sys.stderr,
            )
    if waiting:
        print(f"campaign: {waiting} tasks that need them were not tried", file=sys.stderr)
    print(f"report: {page}")
    return FAILED if failed else 0


def main() -> int:
    options = arguments()
    from polhode_ground.common.errors import BadInput

    if options.report is None and (options.plan is None or (options.out is None and not options.check)):
        raise BadInput("PLAN.toml and --out DIR are needed, or --report DIR")
    install_missing()
    try:
        if options.report is None:
            return run_campaign(options)
        from polhode_ground.campaigns.report import write_report

        page, figures = write_report(options.report.resolve(), options.vs)
        print(f"{figures}\nreport: {page}")
        return 0
    except OSError as problem:  # a full disk, a folder that can't be written
        print(f"campaign: {problem.filename or options.out or options.report}: {problem.strerror or problem}", file=sys.stderr)
        return FAILED


def command() -> None:
    enter_venv()
    run_main(main, "campaign")
