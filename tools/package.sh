#!/usr/bin/env bash
# Builds the Debian packages into build/packages and runs lintian over them: polhode, libpolhode1, libpolhode-dev, polhode-ground.
#   tools/package.sh            build and lint
#   tools/package.sh check      also install them into a bare Debian 12 root, run the sample there, remove them (hil/bare_root.sh)
#   tools/package.sh container  the image polhode-ground of the packages that are there, by podman or docker
set -euo pipefail
cd "$(dirname "$0")/.."
case ${1:-} in
  "" | check) ;;
  container)
    ls build/packages/polhode-ground_*_all.deb >/dev/null 2>&1 || { echo "package: no packages in build/packages; tools/package.sh makes them" >&2; exit 2; }
    for builder in podman docker; do
      if "$builder" info >/dev/null 2>&1; then
        exec "$builder" build -f platform/debian/Containerfile -t polhode-ground build/packages
      fi
    done
    echo "package: neither podman nor docker can build here" >&2
    exit 2 ;;
  -h | --help) sed -n '2,5s/^# //p' "$0"; exit 0 ;;
  *) echo "package: unknown argument '$1'; allowed: check, container, or nothing" >&2; exit 2 ;;
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
