#!/usr/bin/env bash
# Sets up a bare Debian 12 machine: the distribution's packages that the build needs, and the Python side of the tools in
# .venv. Does only what is missing, so that a second call takes a second.
set -euo pipefail
cd "$(dirname "$0")/.."

# The one list of packages.
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
REQUIREMENTS=tools/requirements.txt
STAMP=.venv/.installed-requirements

say() { printf '== %s\n' "$*"; }

missing_packages() {
  local package
  for package in "${PACKAGES[@]}"; do
    if [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
      echo "$package"
    fi
  done
}

install_packages() {
  local missing=() as_root=()
  mapfile -t missing < <(missing_packages)
  if [ "${#missing[@]}" -eq 0 ]; then
    say "packages: all ${#PACKAGES[@]} are installed"
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

install_python_side() {
  if [ -x .venv/bin/python ] && cmp -s "$REQUIREMENTS" "$STAMP"; then
    say "python: .venv is up to date"
    return
  fi
  say "python: installing $REQUIREMENTS into .venv"
  [ -x .venv/bin/python ] || /usr/bin/python3 -m venv .venv
  .venv/bin/python -m pip install --disable-pip-version-check --progress-bar off -r "$REQUIREMENTS"
  cp "$REQUIREMENTS" "$STAMP"
}

command -v apt-get >/dev/null || { echo "setup: this script is for Debian 12; the packages it needs: ${PACKAGES[*]}" >&2; exit 1; }
install_packages
install_python_side
