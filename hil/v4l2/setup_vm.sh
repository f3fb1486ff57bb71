#!/usr/bin/env bash
# Fetches what the virtual machine with the camera needs and builds its kernel module: an emulator and V4L2's own tools from
# the distribution, its kernel and headers unpacked (not installed) below build/v4l2_vm. Does only what is missing.
set -euo pipefail
cd "$(dirname "$0")/../.."
PACKAGES=(qemu-system-x86 busybox-static v4l-utils kmod cpio make gcc)
PLACE=$PWD/build/v4l2_vm
KERNEL=$PLACE/kernel

say() { printf '== %s\n' "$*"; }

install_packages() {
  local package missing=() as_root=()
  for package in "${PACKAGES[@]}"; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  [ "${#missing[@]}" -gt 0 ] || return 0
  [ "$(id -u)" -eq 0 ] || as_root=(sudo)
  say "packages: installing ${missing[*]}"
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
}

# The one package that a package of the distribution stands for.
depends_on() { apt-cache depends "$1" | sed -n "s/^ *Depends: \($2\)$/\1/p" | head -1; }

unpack_kernel() {
  local image headers common kbuild package
  [ ! -e "$KERNEL/.complete" ] || return 0
  image=$(depends_on linux-image-amd64 'linux-image-.*-amd64')
  headers=$(depends_on linux-headers-amd64 'linux-headers-.*-amd64')
  common=$(depends_on "$headers" 'linux-headers-.*-common')
  kbuild=$(depends_on "$headers" 'linux-kbuild-.*')
  say "kernel: unpacking $image $headers $common $kbuild"
  rm -rf "$KERNEL" "$PLACE/packages"
  mkdir -p "$KERNEL" "$PLACE/packages"
  (cd "$PLACE/packages" && apt-get download -q "$image" "$headers" "$common" "$kbuild")
  for package in "$PLACE"/packages/*.deb; do
    dpkg -x "$package" "$KERNEL"
  done
  rm -rf "$PLACE/packages"
  echo "${image#linux-image-}" > "$KERNEL/release"
  touch "$KERNEL/.complete"
}

# The headers' makefiles include each other by absolute path: pointed at where they are unpacked.
build_module() {
  local release headers module=$PLACE/module
  release=$(cat "$KERNEL/release")
  headers=$KERNEL/usr/src/linux-headers-$release
  if [ -e "$module/filecam.ko" ] && [ -z "$(find hil/v4l2/filecam -newer "$module/filecam.ko")" ]; then
    return 0
  fi
  say "module: building filecam for $release"
  rm -rf "$module"
  cp -r hil/v4l2/filecam "$module"
  ln -sfn "$KERNEL"/usr/lib/linux-kbuild-*/scripts "$KERNEL/usr/src/scripts"
  sed "s#/usr/src/#$KERNEL/usr/src/#g" "$headers/Makefile" > "$headers/Makefile.here"
  make -s -C "$headers" -f Makefile.here M="$module" KERNELRELEASE="$release" modules
}

install_packages
mkdir -p "$PLACE"
unpack_kernel
build_module
