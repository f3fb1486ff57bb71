#!/usr/bin/env bash
# Builds the Debian packages into build/packages and runs lintian over them: polhode, libpolhode1, libpolhode-dev, polhode-ground.
#   tools/package.sh            build and lint
#   tools/package.sh check      also install them into a bare Debian 12 root, run the sample there, remove them (hil/bare_root.sh)
set -euo pipefail
cd "$(dirname "$0")/.."
case ${1:-} in
  "" | check) ;;
  -h | --help) sed -n '2,4s/^# //p' "$0"; exit 0 ;;
  *) echo "package: unknown argument '$1'; allowed: check, or nothing" >&2; exit 2 ;;
esac

tools/setup.sh
tools/setup.sh packages
tools/build.sh package polhode polhode_c
rm -rf build/packages
cmake --build --preset package --target package
rm -rf build/packages/_CPack_Packages
printf '== lintian\n'
lintian --allow-root --fail-on error --tag-display-limit 0 build/packages/*.deb
ls -l build/packages
if [ "${1:-}" = check ]; then
  hil/bare_root.sh build/packages
fi
