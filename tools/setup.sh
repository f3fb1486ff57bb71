#!/usr/bin/env bash
# Sets up a bare Debian 12 machine. Does only what is missing, so that a second call takes a second.
#   tools/setup.sh            what building and running the program takes, and the Python side of the tools in .venv
#   tools/setup.sh tests      also what tools/run_tests.sh needs, which calls this by itself: GoogleTest, clang's tools, Valgrind, clients of the bus
#   tools/setup.sh renderer   only Blender, for hil/render_scene.sh, which calls this by itself
#   tools/setup.sh colmap     only COLMAP in .venv-colmap, for hil/compare_colmap.py, which calls this by itself
#   tools/setup.sh extras     only what single tests and exports need beyond that (tools/requirements-extras.txt), into .venv
#   tools/setup.sh campaign   only what hil/campaign.py needs, into .venv, which calls this by itself
#   tools/setup.sh site       only what makes the site, for tools/make_site.py: Doxygen, and tools/requirements-site.txt into .venv
#   tools/setup.sh browser    only a browser, for the tests of pages
#   tools/setup.sh packages   only what builds and checks Debian packages, for tools/package.sh, which calls this by itself
#   tools/setup.sh processors only an emulator of other x86-64 processors, for tools/other_processors.py
#   tools/setup.sh arm64      only what builds and runs arm64 programs here, for tools/check_arm64.sh, which calls this by itself
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
cd "$(dirname "$0")/.."

# The one list of packages for the build.
TOOLS=(cmake g++ ninja-build pkg-config python3 python3-venv)
LIBRARIES=(
  # estimation: linear algebra, least squares, minimal solvers, image operations, nearest neighbours, elementary functions
  libceres-dev libeigen3-dev libflann-dev liblz4-dev libopencv-dev libopengv-dev libsleef-dev
  # platform: images, configuration, command line, text, JSON, SHA-256
  libcli11-dev libfmt-dev libgoogle-glog-dev libjpeg62-turbo-dev libpng-dev libssl-dev libtomlplusplus-dev libturbojpeg0-dev libyaml-cpp-dev nlohmann-json3-dev
)
TEST_TOOLS=(clang-format clang-tidy strace systemd valgrind)
TEST_LIBRARIES=(libgtest-dev)
OWN_PACKAGES=(tools platform/transport/client/python)
# Kept apart from the build: Blender is large, and COLMAP is only there to be compared with.
RENDERER_PACKAGES=(blender python3-numpy)
COLMAP_PACKAGES=(python3 python3-venv)
BROWSER_PACKAGES=(chromium fonts-dejavu-core)
SITE_PACKAGES=(doxygen python3 python3-venv)
DEBIAN_PACKAGES=(dpkg-dev fakeroot lintian mmdebstrap)
ARM64_PACKAGES=(cmake g++-aarch64-linux-gnu ninja-build pkg-config python3 python3-venv qemu-user-static)
# The same place stands in config/aarch64.cmake.
ARM64_SYSROOT=${XDG_CACHE_HOME:-$HOME/.cache}/polhode/sysroot-arm64

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
  local venv=$1 requirements=$2
  local stamp=$venv/.installed-$(basename "$requirements")
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

# The project's own packages, as links to their folders: a change there needs no second call.
install_own_packages() {
  local stamp=.venv/.installed-own
  if cat "${OWN_PACKAGES[@]/%//pyproject.toml}" | cmp -s - "$stamp"; then
    say "python: own packages are up to date"
    return
  fi
  say "python: linking ${OWN_PACKAGES[*]} into .venv"
  .venv/bin/python -m pip install --disable-pip-version-check --progress-bar off --no-index --no-build-isolation --no-deps "${OWN_PACKAGES[@]/#/--editable=}"
  cat "${OWN_PACKAGES[@]/%//pyproject.toml}" > "$stamp"
}

# install_project REQUIREMENTS...: into .venv, with what every command needs
install_project() {
  local requirements
  for requirements in tools/requirements.txt "$@"; do
    install_python_side .venv "$requirements"
  done
  install_own_packages
}

# apt_arm64 FOLDER ARGUMENTS: apt for a machine of that architecture on which nothing is installed, as far as FOLDER knows.
apt_arm64() {
  local state=$1
  shift
  mkdir -p "$state/lists/partial" "$state/archives/partial"
  : > "$state/status"
  apt-get -q -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User="$(id -un)" -o Dir::Cache="$state" \
    -o Dir::State="$state" -o Dir::State::Lists="$state/lists" -o Dir::State::status="$state/status" "$@"
}

# What packages' own scripts and CMake files take for granted on a machine where they are installed.
settle_sysroot() {
  local root=$1 link library
  find "$root" -type l -lname '/*' | while read -r link; do
    ln -sfnr "$root$(readlink "$link")" "$link"
  done
  for library in libblas.so libblas.so.3 liblapack.so liblapack.so.3; do  # elsewhere a choice among packages; here one is unpacked
    ln -sfnr "$(find "$root/usr/lib" -mindepth 2 -name "$library" | head -1)" "$root/usr/lib/aarch64-linux-gnu/$library"
  done
  sed -i "s#\([\";]\)/usr/\(lib\|include\)#\1$ARM64_SYSROOT/usr/\2#g" "$root"/usr/lib/aarch64-linux-gnu/cmake/{Ceres/Ceres,opengv/opengv}Targets.cmake
}

# unpack PACKAGE ROOT: its files, and its part of a database of dpkg's own form, which names the files where they will stand. By it
# dpkg-shlibdeps and dpkg-query find the package of a library, and the version that its symbols need.
unpack() {
  local database=$2/var/lib/dpkg control=$2/../control name file
  mkdir -p "$database/info" "$database/updates"
  rm -rf "$control"
  dpkg-deb -e "$1" "$control"
  name=$(sed -n 's/^Package: //p' "$control/control")
  ! grep -qx 'Multi-Arch: same' "$control/control" || name=$name:arm64
  { cat "$control/control"; printf 'Status: install ok installed\n\n'; } >> "$database/status"
  dpkg-deb -X "$1" "$2" | sed -n "s#^\./\(.*[^/]\)\$#$ARM64_SYSROOT/\1#p" > "$database/info/$name.list"
  for file in symbols shlibs; do
    [ ! -e "$control/$file" ] || mv "$control/$file" "$database/info/$name.$file"
  done
}

# The libraries for arm64, unpacked and not installed: the machine's own packages stay as they are.
make_sysroot() {
  local new=$ARM64_SYSROOT.new wanted=("${LIBRARIES[@]}" "${TEST_LIBRARIES[@]}") package
  if [ "$(cat "$ARM64_SYSROOT/packages" 2>/dev/null)" = "${wanted[*]}" ] && [ -s "$ARM64_SYSROOT/var/lib/dpkg/status" ]; then
    say "sysroot: $ARM64_SYSROOT is up to date"
    return
  fi
  say "sysroot: fetching packages for arm64 (about 250 MB)"
  rm -rf "$new"
  mkdir -p "$new/tree"
  apt_arm64 "$new" update
  apt_arm64 "$new" install -y --no-install-recommends --download-only "${wanted[@]}" libc6-dev
  say "sysroot: unpacking into $ARM64_SYSROOT (about 1.1 GB)"
  for package in "$new"/archives/*.deb; do
    unpack "$package" "$new/tree"
  done
  printf '%s\n' "$(dpkg --print-architecture)" arm64 > "$new/tree/var/lib/dpkg/arch"
  echo 1 > "$new/tree/var/lib/dpkg/info/format"
  settle_sysroot "$new/tree"
  echo "${wanted[*]}" > "$new/tree/packages"
  [ ! -e "$ARM64_SYSROOT" ] || mv "$ARM64_SYSROOT" "$new/before"  # at once: a build may be reading it
  mv "$new/tree" "$ARM64_SYSROOT"
  rm -rf "$new"
}

case ${1:-} in
  "")
    install_packages "${TOOLS[@]}" "${LIBRARIES[@]}"
    install_project ;;
  tests)
    install_packages "${TOOLS[@]}" "${LIBRARIES[@]}" "${TEST_TOOLS[@]}" "${TEST_LIBRARIES[@]}"
    install_project tools/requirements-tests.txt tools/requirements-campaign.txt ;;
  renderer)
    install_packages "${RENDERER_PACKAGES[@]}" ;;
  campaign)
    install_packages python3 python3-venv
    install_project tools/requirements-campaign.txt ;;
  extras)
    install_packages python3 python3-venv
    install_project tools/requirements-extras.txt ;;
  site)
    install_packages "${SITE_PACKAGES[@]}"
    install_project tools/requirements-site.txt ;;
  browser)
    install_packages "${BROWSER_PACKAGES[@]}" ;;
  packages)
    install_packages "${DEBIAN_PACKAGES[@]}" ;;
  colmap)
    install_packages "${COLMAP_PACKAGES[@]}"
    install_python_side .venv-colmap tools/requirements-colmap.txt ;;
  processors)
    install_packages qemu-user-static ;;
  arm64)
    install_packages "${ARM64_PACKAGES[@]}"
    make_sysroot ;;
  -h | --help)
    sed -n '2,13s/^# //p' "$0" ;;
  *)
    echo "setup: unknown part '$1'; allowed: tests, browser, renderer, colmap, extras, campaign, site, packages, processors, arm64, or nothing" >&2
    exit 2 ;;
esac
