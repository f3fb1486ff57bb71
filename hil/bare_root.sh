#!/usr/bin/env bash
# Installs the Debian packages of a folder into a bare Debian 12 root, as its own package manager does, uses them and removes them.
#   hil/bare_root.sh FOLDER [WORK]     WORK: folder for the root, kept; without it a temporary one
# Takes root, mmdebstrap and Debian's archive (tools/setup.sh packages). Nothing of this machine is changed. Ten minutes at most.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ $# -lt 1 ] || [ "$1" = -h ] || [ "$1" = --help ]; then
  sed -n '2,4s/^# //p' "$0"
  exit $(($# < 1 ? 2 : 0))
fi
FOLDER=$(realpath "$1")
ls "$FOLDER"/polhode_*.deb >/dev/null 2>&1 || { echo "bare_root: $FOLDER: no polhode_*.deb; tools/package.sh makes them" >&2; exit 2; }
command -v mmdebstrap >/dev/null || { echo "bare_root: mmdebstrap is not installed (tools/setup.sh packages)" >&2; exit 2; }
if [ -n "${2:-}" ]; then
  WORK=$(realpath "$2")
  if [ -e "$WORK/root" ] && [ ! -e "$WORK/.polhode-root" ]; then
    echo "bare_root: $WORK/root: is there already and was not made here; give another folder" >&2
    exit 2
  fi
  mkdir -p "$WORK"
  touch "$WORK/.polhode-root"
else
  WORK=$(mktemp -d)
  trap 'rm -rf "$WORK"' EXIT
fi
ROOT=$WORK/root
. hil/bare_root.inc

# What stands on the disk, without what apt and dpkg keep about themselves.
listing() { (cd "$ROOT" && find . -xdev \( -path ./proc -o -path ./var/lib/dpkg -o -path ./var/lib/apt -o -path ./var/cache -o -path ./var/log -o -path ./pkg -o -path ./tmp \) -prune -o -print | sort); }

printf '== a bare root\n'
make_root
mkdir -p "$ROOT/pkg"
cp "$FOLDER"/*.deb "$ROOT/pkg"
cp -r hil/data/sample "$ROOT/pkg/sample"
inside dpkg-query -W -f '${Package}\n' > "$WORK/before"

printf '== install\n'
inside sh -c 'apt-get -q -q update && apt-get -q -q install -y --no-install-recommends /pkg/polhode_*.deb /pkg/libpolhode1_*.deb /pkg/polhode-ground_*.deb' >"$WORK/install.log" 2>&1 || { tail -20 "$WORK/install.log" >&2; exit 1; }
inside dpkg-query -W -f '${Package}\n' | comm -13 "$WORK/before" - > "$WORK/came"
printf '%s packages came with them; %s MB in all\n' "$(wc -l < "$WORK/came")" "$(inside dpkg-query -W -f '${Package} ${Installed-Size}\n' | grep -wFf "$WORK/came" | awk '{ sum += $2 } END { print int(sum / 1024) }')"

printf '== use\n'
inside polhode --version
inside polhode check --config /etc/polhode/live.toml >/dev/null
inside polhode replay --config /usr/share/polhode/default.toml --sequence /pkg/sample --out /pkg/out
inside python3 -c '
import polhode_bus
with polhode_bus.open_bus("file:/pkg/out/bus.ccsds") as bus:
    count = sum(1 for _ in bus.packets(timeout_s=1.0))
print(count, "packets decoded by the ground package")
assert count > 90'
inside id polhode
echo "sha256 of the sample's stream: $(sha256sum < "$ROOT/pkg/out/bus.ccsds" | cut -d' ' -f1)"

printf '== remove\n'
inside apt-get -q -q purge -y polhode libpolhode1 polhode-ground >>"$WORK/install.log" 2>&1
inside apt-get -q -q autoremove --purge -y >>"$WORK/install.log" 2>&1
listing | grep -i polhode && { echo "bare_root: remains, listed above" >&2; exit 1; }
if inside getent passwd polhode; then echo "bare_root: the user polhode remains" >&2; exit 1; fi
printf 'nothing of it remains\n'

# COPY and RUN as a builder of containers takes them, then what the container runs, as its user.
printf '== the container of the ground side\n'
rm -rf "$ROOT/pkg"/*.deb
while read word rest; do  # without -r, so that a line goes on behind a backslash
  case $word in
    COPY) for file in $(cd "$FOLDER" && printf '%s ' ${rest% *}); do cp "$FOLDER/$file" "$ROOT${rest##* }"; done ;;
    RUN) inside sh -c "$rest" >>"$WORK/install.log" 2>&1 || { tail -20 "$WORK/install.log" >&2; exit 1; } ;;
    USER) user=$rest ;;
    ENTRYPOINT) read -ra entry <<< "$(tr -d '[],"' <<< "$rest")" ;;
    FROM) [ "$rest" = debian:bookworm-slim ] || { echo "bare_root: platform/debian/Containerfile begins from $rest" >&2; exit 1; } ;;
    '#'* | '') ;;
    *) echo "bare_root: platform/debian/Containerfile: $word is not known here" >&2; exit 1 ;;
  esac
done < platform/debian/Containerfile
rows=$(inside setpriv --reuid="$user" --regid="$user" --clear-groups "${entry[@]}" file:/pkg/out/bus.ccsds | grep -c 'rad/s$') || true
printf '%s rates printed by the container as user %s\n' "$rows" "$user"
[ "$rows" -gt 80 ] || { echo "bare_root: the container of the ground side prints $rows rates" >&2; exit 1; }
