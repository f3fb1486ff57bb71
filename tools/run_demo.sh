#!/usr/bin/env bash
# From a fresh machine to pictures: set-up, build, replay of the shipped sample, judgement against its truth, plots.
#   tools/run_demo.sh    results in build/demo
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in -h | --help) sed -n '2,3s/^# //p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
SEQUENCE=hil/data/sample
OUT=build/demo

# say TEXT: with the time since the start.
say() { printf '== %d:%02d  %s\n' $((SECONDS / 60)) $((SECONDS % 60)) "$*"; }

say "1 of 5: packages (two minutes on a bare machine, a second where they are installed)"
tools/setup.sh
say "2 of 5: the program (four to eight minutes on two cores, seconds where it is built)"
tools/build.sh release polhode

# One known edge of the target gives metres; without it the results are in map units.
mapfile -t scale < <(.venv/bin/python -m polhode_ground.judge.paper scale "$SEQUENCE")
say "3 of 5: replay of $SEQUENCE ${scale[*]} (ten seconds)"
build/release/bin/polhode replay --config config/default.toml --sequence "$SEQUENCE" --out "$OUT" "${scale[@]}"

say "4 of 5: judgement against the truth"
.venv/bin/python hil/evaluate.py "$OUT" "$SEQUENCE"

say "5 of 5: pictures"
.venv/bin/python tools/plot_replay.py "$OUT" --sequence "$SEQUENCE" --truth "$SEQUENCE/truth.csv"
.venv/bin/python tools/report.py "$OUT" --sequence "$SEQUENCE"

say "found"
.venv/bin/python - "$OUT/summary.json" <<'PYTHON'
import json, sys
summary = json.load(open(sys.argv[1]))
step, memory = summary["timings"]["step"], summary["memory"]
print(summary["result"])
print(f"A frame takes {step['p50_us'] / 1000:.1f} ms (median), {step['max_us'] / 1000:.1f} ms at most; "
      f"the process takes {memory['peak_resident_octets'] / 1e6:.0f} MB at most.")
PYTHON
say "open $OUT/report.html in a browser; pictures are in $OUT/plots, all other results in $OUT"
