#!/usr/bin/env bash
# Builds the Debian packages into build/packages and checks them: polhode, libpolhode1, libpolhode-dev, polhode-ground.
#   tools/package.sh            build, lint, check contents and dependencies (tools/check_packages.py)
#   tools/package.sh check      also install them into a bare Debian 12 root, run the sample there, remove them (hil/bare_root.sh)
#   tools/package.sh arm64      the same as without, for arm64, into build/packages-arm64; compared with those in build/packages
#   tools/package.sh container  the image polhode-ground of the packages that are there, by podman or docker
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
cd "$(dirname "$0")/.."

# build_packages PRESET FOLDER
build_packages() {
  tools/build.sh "$1" polhode polhode_c
  rm -rf "$2"
  cmake --build --preset "$1" --target package
  rm -rf "$2/_CPack_Packages"
  printf '== lintian\n'
  lintian --allow-root --fail-on error --tag-display-limit 0 "$2"/*.deb
  ls -l "$2"
  printf '== contents and dependencies\n'
}

case ${1:-} in
  "" | check)
    tools/setup.sh
    tools/setup.sh packages
    build_packages package build/packages
    tools/check_packages.py build/packages
    [ -z "${1:-}" ] || hil/bare_root.sh build/packages ;;
  arm64)
    tools/setup.sh arm64
    tools/setup.sh packages
    # For dpkg-shlibdeps: the packages of the sysroot, whose place stands in tools/setup.sh, too.
    export DPKG_ADMINDIR=${XDG_CACHE_HOME:-$HOME/.cache}/polhode/sysroot-arm64/var/lib/dpkg
    build_packages package-aarch64 build/packages-arm64
    like=()
    if ls build/packages/*.deb >/dev/null 2>&1; then
      like=(--like build/packages)
    else
      echo "no packages in build/packages to compare with"
    fi
    tools/check_packages.py build/packages-arm64 --database "$DPKG_ADMINDIR" "${like[@]}" ;;
  container)
    ls build/packages/polhode-ground_*_all.deb >/dev/null 2>&1 || { echo "package: no packages in build/packages; tools/package.sh makes them" >&2; exit 2; }
    for builder in podman docker; do
      if "$builder" info >/dev/null 2>&1; then
        exec "$builder" build -f platform/debian/Containerfile -t polhode-ground build/packages
      fi
    done
    echo "package: neither podman nor docker can build here" >&2
    exit 2 ;;
  -h | --help) sed -n '2,6s/^# //p' "$0" ;;
  *) echo "package: unknown argument '$1'; allowed: check, arm64, container, or nothing" >&2; exit 2 ;;
esac
