#!/usr/bin/env bash
# A ground station for Polhode's bus: a YAMCS server that archives and decodes the packets that come by UDP, and a page that
# shows rates over time, attitude and measured body, prediction, alarms, health and events. Commands are counted and verified.
#   hil/ground_station.sh [--tm PORT] [--tc PORT] [--http PORT] [--page PORT] [--data DIR] [--key FILE] [--install]
#   --tm 10015  telemetry comes here: [transport] send = ["udp:10015"]      --tc 10016  commands go there
#   --http 8090 the server's own pages (archive, commands, links)           --page 8091 the display
#   --key FILE  sign commands with this key (docs/security.md); without it they are not signed
#   --data DIR  archive (default: build/ground_station)                     --install   only fetch what it needs
# The server comes from Maven Central once (60 MB), into ~/.cache/polhode. Its telemetry link listens on every interface of the
# machine, as it knows no other way: on an open network put a firewall before the port.
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
cd "$(dirname "$0")/.."

VERSION=5.13.2
LIBRARIES=${XDG_CACHE_HOME:-$HOME/.cache}/polhode/yamcs-$VERSION
TM=10015 TC=10016 HTTP=8090 PAGE=8091 DATA=build/ground_station KEY= install=false

say() { printf '== %s\n' "$*"; }
fail() { echo "ground_station: $*" >&2; exit 2; }

while [ $# -gt 0 ]; do
  case $1 in
    --tm) TM=${2:?}; shift 2 ;;
    --tc) TC=${2:?}; shift 2 ;;
    --http) HTTP=${2:?}; shift 2 ;;
    --page) PAGE=${2:?}; shift 2 ;;
    --data) DATA=${2:?}; shift 2 ;;
    --key) KEY=$(realpath "${2:?}"); shift 2 ;;
    --install) install=true; shift ;;
    -h | --help) sed -n '2,10s/^# //p' "$0"; exit 0 ;;
    *) fail "unknown argument '$1'" ;;
  esac
done

install_packages() {
  local missing=() package as_root=()
  for package in openjdk-17-jdk-headless maven python3; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  if command -v javac >/dev/null && command -v mvn >/dev/null; then return; fi
  [ "$(id -u)" -eq 0 ] || as_root=(sudo)
  say "packages: installing ${missing[*]}"
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
}

fetch_server() {
  [ -e "$LIBRARIES/complete" ] && return
  say "server: fetching YAMCS $VERSION into $LIBRARIES"
  mkdir -p "$LIBRARIES"
  mvn -q -B -f hil/ground_station/pom.xml dependency:copy-dependencies -DincludeScope=runtime -DoutputDirectory="$LIBRARIES/lib"
  touch "$LIBRARIES/complete"
}

configure() {
  if [ -n "$(ls -A "$DATA" 2>/dev/null)" ] && [ ! -e "$DATA/etc/yamcs.polhode.yaml" ]; then fail "--data $DATA: holds other files; allowed is a new, an empty or an earlier archive's folder"; fi
  mkdir -p "$DATA/etc" "$DATA/archive" "$DATA/cache"
  DATA=$(realpath "$DATA")
  local file postprocessor=CountingCommandPostprocessor
  if [ -n "$KEY" ]; then postprocessor=SigningCommandPostprocessor; fi
  javac -cp "$LIBRARIES/lib/*" -d "$DATA/classes" hil/ground_station/commanding/*.java
  for file in hil/ground_station/etc/*.yaml; do
    sed -e "s|@HTTP_PORT@|$HTTP|g; s|@TM_PORT@|$TM|g; s|@TC_PORT@|$TC|g; s|@TC_POSTPROCESSOR@|$postprocessor|g; s|@TC_KEY@|$KEY|g; s|@MDB@|$PWD/config/bus|g" "$file" >"$DATA/etc/$(basename "$file")"
  done
}

install_packages
fetch_server
if $install; then exit 0; fi
configure
for port in "$HTTP" "$PAGE"; do
  if (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; then fail "port $port is in use"; fi
done

say "display: http://127.0.0.1:$PAGE/?yamcs=$HTTP   server: http://127.0.0.1:$HTTP   telemetry: udp:$TM   commands to udp:$TC"
children=()
trap 'kill "${children[@]}" 2>/dev/null; wait' EXIT
trap 'exit 0' INT TERM
python3 -m http.server --bind 127.0.0.1 --directory hil/ground_station/display "$PAGE" >/dev/null 2>&1 &
children+=($!)
java -Xmx256m -cp "$DATA/classes:$LIBRARIES/lib/*" org.yamcs.YamcsServer --etc-dir "$DATA/etc" --data-dir "$DATA/archive" --cache-dir "$DATA/cache" &
children+=($!)
wait "${children[1]}"
