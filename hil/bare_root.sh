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
else
  WORK=$(mktemp -d)
  trap 'rm -rf "$WORK"' EXIT
fi
ROOT=$WORK/root

inside() { unshare --mount --pid --fork --uts bash -c 'mount -t proc proc "$0/proc" && exec chroot "$0" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive "$@"' "$ROOT" "$@"; }
# What stands on the disk, without what apt and dpkg keep about themselves.
listing() { (cd "$ROOT" && find . -xdev \( -path ./proc -o -path ./var/lib/dpkg -o -path ./var/lib/apt -o -path ./var/cache -o -path ./var/log -o -path ./pkg -o -path ./tmp \) -prune -o -print | sort); }

printf '== a bare root\n'
rm -rf "$ROOT"
# Its archive is this machine's. Services are not started in it.
mmdebstrap --quiet --variant=minbase --include=ca-certificates bookworm "$ROOT"
for file in /etc/resolv.conf /etc/apt/apt.conf.d/*proxy* /usr/local/share/ca-certificates; do
  [ ! -e "$file" ] || { mkdir -p "$ROOT$(dirname "$file")"; cp -rL "$file" "$ROOT$file"; }
done
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
