#!/usr/bin/env bash
# Sets up a bare Debian 12 machine. Does only what is missing, so that a second call takes a second.
#   tools/setup.sh            the distribution's packages that the build needs, and the Python side of the tools in .venv
#   tools/setup.sh renderer   only Blender, for hil/render_scene.sh, which calls this by itself
#   tools/setup.sh colmap     only COLMAP in .venv-colmap, for hil/compare_colmap.py, which calls this by itself
set -euo pipefail
cd "$(dirname "$0")/.."

# The one list of packages for the build and the tests.
PACKAGES=(
  # tools
  cmake g++ ninja-build pkg-config python3 python3-venv
  # estimation: linear algebra, least squares, minimal solvers, image operations, nearest neighbours
  libceres-dev libeigen3-dev liblz4-dev libopencv-dev libopengv-dev
  # platform: images, configuration, command line, text, JSON, SHA-256
  libcli11-dev libfmt-dev libgoogle-glog-dev libjpeg62-turbo-dev libpng-dev libssl-dev libtomlplusplus-dev libturbojpeg0-dev libyaml-cpp-dev nlohmann-json3-dev
  # tests
  libgtest-dev valgrind
)
# Kept apart from the build: Blender is large, and COLMAP is only there to be compared with.
RENDERER_PACKAGES=(blender python3-numpy)
COLMAP_PACKAGES=(python3 python3-venv)

say() { printf '== %s\n' "$*"; }

missing_of() {
  local package
  for package in "$@"; do
    if [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
      echo "$package"
    fi
  done
}

install_packages() {
  local missing=() as_root=()
  command -v apt-get >/dev/null || { echo "setup: this script is for Debian 12; the packages it needs: $*" >&2; exit 1; }
  mapfile -t missing < <(missing_of "$@")
  if [ "${#missing[@]}" -eq 0 ]; then
    say "packages: all $# are installed"
    return
  fi
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "setup: run as root or install sudo; missing: ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
  fi
  say "packages: installing ${missing[*]}"
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
}

# install_python_side VENV REQUIREMENTS
install_python_side() {
  local venv=$1 requirements=$2 stamp=$1/.installed-requirements
  if [ -x "$venv/bin/python" ] && cmp -s "$requirements" "$stamp"; then
    say "python: $venv is up to date"
    return
  fi
  say "python: installing $requirements into $venv"
  # pip comes last into a new environment: without it an earlier call was interrupted.
  [ -x "$venv/bin/pip" ] || /usr/bin/python3 -m venv "$venv"
  "$venv/bin/python" -m pip install --disable-pip-version-check --progress-bar off -r "$requirements"
  cp "$requirements" "$stamp"
}

case ${1:-} in
  "")
    install_packages "${PACKAGES[@]}"
    install_python_side .venv tools/requirements.txt ;;
  renderer)
    install_packages "${RENDERER_PACKAGES[@]}" ;;
  colmap)
    install_packages "${COLMAP_PACKAGES[@]}"
    install_python_side .venv-colmap tools/requirements-colmap.txt ;;
  -h | --help)
    sed -n '2,5s/^# //p' "$0" ;;
  *)
    echo "setup: unknown part '$1'; allowed: renderer, colmap, or nothing" >&2
    exit 2 ;;
esac
