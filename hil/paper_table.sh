#!/usr/bin/env bash
# The paper's two cases with truth: renders them (or reuses them), replays them, and prints the paper's figures beside ours.
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
here=$(cd "$(dirname "$0")/.." && pwd)

usage() {
  cat <<'TEXT'
Usage: hil/paper_table.sh [--small] [--case 2d|3d] [--set key=value]...

Renders hil/scenes/paper_2d.toml and paper_3d.toml into the cache (a rendering that is there is reused, an interrupted
one goes on), replays both with build/release/bin/polhode, the known length of the scene giving the scale, and prints
the paper's figures beside ours. The plots of the paper's figures are in each replay's folder "plots".

  --small          the small variants: minutes instead of half an hour; the motion is the same, the picture coarser
  --case 2d|3d     only one of the two
  --set key=value  handed to the replay
Cache: ${POLHODE_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/polhode}, with scenes/NAME and replays/NAME.
Exit status: 0 both cases done (an estimate may still be missing: the table says so), 1 a step failed, 2 unusable arguments.
TEXT
}

fail() { echo "paper_table: $1" >&2; exit "$2"; }

variant=() suffix="" cases="2d 3d" settings=()
while [ $# -gt 0 ]; do
  case $1 in
    --small) variant=(--variant small) suffix=_small ;;
    --case) case ${2:-} in 2d | 3d) cases=$2 ;; *) fail "--case takes 2d or 3d, not '${2:-}'" 2 ;; esac; shift ;;
    --set) [ $# -gt 1 ] || fail "--set takes key=value" 2; settings+=(--set "$2"); shift ;;
    -h | --help) usage; exit 0 ;;
    *) fail "unknown argument '$1' (see --help)" 2 ;;
  esac
  shift
done

polhode="$here/build/release/bin/polhode"
python="$here/.venv/bin/python3"
[ -x "$polhode" ] || fail "build/release/bin/polhode is not there: build it first (cmake --preset release && cmake --build --preset release)" 2
[ -x "$python" ] || fail ".venv is not there: run tools/setup.sh first" 2
cache=${POLHODE_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/polhode}

say() { printf '== %s\n' "$*"; }

# Renders, replays, judges and draws one case; leaves the judge's JSON at $cache/replays/NAME.json.
run_case() {
  local name=paper_$1$suffix
  local scene="$here/hil/scenes/paper_$1.toml" sequence="$cache/scenes/$name" out="$cache/replays/$name"
  [ -f "$scene" ] || fail "hil/scenes/paper_$1.toml is not there" 2
  mkdir -p "$cache/scenes" "$cache/replays"
  say "$name: frames in $sequence"
  "$here/hil/render_scene.sh" "$scene" "$sequence" "${variant[@]}" \
    || fail "$name: rendering failed; if the scene file has changed since, remove $sequence" 1
  local scale=()
  mapfile -t scale < <("$python" -m polhode_ground.judge.paper scale "$sequence")
  [ "${#scale[@]}" -gt 1 ] || { scale=(); say "$name: no known length is seen well, so the scale comes from the alignment"; }
  say "$name: replay into $out"
  "$polhode" replay --config "$here/config/default.toml" --sequence "$sequence" --out "$out" "${scale[@]}" "${settings[@]}" \
    || fail "$name: the replay failed" 1
  "$here/hil/evaluate.py" "$out" "$sequence" --json "$cache/replays/$name.json" > "$cache/replays/$name.txt" \
    || fail "$name: the judge failed" 1
  "$here/tools/plot_replay.py" "$out" --sequence "$sequence" || fail "$name: the plots failed" 1
}

reports=(- -)
for one in $cases; do
  run_case "$one"
  index=$([ "$one" = 2d ] && echo 0 || echo 1)
  reports[index]="$cache/replays/paper_$one$suffix.json"
done
say "the paper's figures beside ours${suffix:+ (small variants)}"
"$python" -m polhode_ground.judge.paper table "${reports[@]}"
echo "The judge's full tables are beside the replays: $cache/replays/paper_*$suffix.txt"
