#!/usr/bin/env bash
# A bare Debian root with systemd, polhode and polhode-ground below build/v4l2_vm/package_root, for the job `package` of hil/v4l2_vm.sh.
# Made anew when a package in build/packages is newer. Takes root and mmdebstrap (tools/setup.sh packages).
set -euo pipefail
cd "$(dirname "$0")/../.."
ROOT=$PWD/build/v4l2_vm/package_root
. hil/bare_root.inc
packages=(build/packages/polhode_*_amd64.deb build/packages/polhode-ground_*_all.deb)
for package in "${packages[@]}"; do
  [ -e "$package" ] || { echo "package_root: $package: not there; tools/package.sh makes it" >&2; exit 2; }
done
if [ -e "$ROOT.made" ] && [ -z "$(find "${packages[@]}" -newer "$ROOT.made")" ]; then
  exit 0
fi
command -v mmdebstrap >/dev/null || { echo "package_root: mmdebstrap is not installed (tools/setup.sh packages)" >&2; exit 2; }
printf '== a root with the packages\n'
rm -f "$ROOT.made"
make_root systemd
mkdir "$ROOT/pkg"
cp "${packages[@]}" "$ROOT/pkg"
inside sh -c 'apt-get -q -q update && apt-get -q -q install -y --no-install-recommends /pkg/*.deb' > "$ROOT.log" 2>&1 || { tail -20 "$ROOT.log" >&2; exit 1; }
touch "$ROOT.made"
