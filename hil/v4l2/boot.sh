#!/usr/bin/env bash
# Boots the virtual machine, runs one job in it and waits for its end.
#   hil/v4l2/boot.sh JOB RESULTS [TIMEOUT_S]
# JOB: a shell script, run in the guest as root with the host's files under their own paths (read-only), the guest's memory
# at /run and /tmp, and RESULTS at /mnt. What it prints is left in RESULTS/console.txt. Status: the job's; 124 after a time-out.
set -euo pipefail
cd "$(dirname "$0")/../.."
JOB=$(realpath "$1")
RESULTS=$(mkdir -p "$2" && realpath "$2")
TIMEOUT_S=${3:-600}
PLACE=$PWD/build/v4l2_vm
KERNEL=$PLACE/kernel
RELEASE=$(cat "$KERNEL/release")
# In the order in which they are loaded; what they need comes first.
MODULES=(9p 9pnet_virtio virtio_pci videobuf2-v4l2 videobuf2-vmalloc vivid overlay)
LOADED_AT_BOOT=(9p 9pnet_virtio virtio_pci)

build_initramfs() {
  local root=$RESULTS/.initramfs module
  rm -rf "$root"
  mkdir -p "$root"/{bin,proc,sys,dev,host,modules}
  cp "$(command -v busybox)" "$root/bin/busybox"
  cp hil/v4l2/guest_init "$root/init"
  chmod +x "$root/init"
  depmod -b "$KERNEL" "$RELEASE"
  dependencies "${MODULES[@]}" | while read -r module; do
    cp "$module" "$root/modules/"
  done
  dependencies "${LOADED_AT_BOOT[@]}" | sed 's#.*/#/modules/#' > "$root/modules/order"
  dependencies videobuf2-v4l2 videobuf2-vmalloc | sed 's#.*/#/run/guest_modules/#' > "$root/modules/filecam.order"
  dependencies vivid | sed 's#.*/#/run/guest_modules/#' > "$root/modules/vivid.order"
  dependencies overlay | sed 's#.*/#/run/guest_modules/#' > "$root/modules/overlay.order"
  cp "$PLACE/module/filecam.ko" "$root/modules/"
  (cd "$root" && find . | cpio -o -H newc --quiet | gzip -1 > "$RESULTS/.initramfs.gz")
  rm -rf "$root"
}

# Files of modules with those that they need before them, each once.
dependencies() {
  local module
  for module in "$@"; do
    modprobe -d "$KERNEL" -S "$RELEASE" --show-depends "$module" | sed -n 's/^insmod \([^ ]*\).*/\1/p'
  done | awk '!seen[$0]++'
}

build_initramfs
rm -f "$RESULTS"/{status,console.txt,boot.txt}
{ echo "export REPOSITORY='$PWD' PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8"; cat "$JOB"; } > "$RESULTS/job.sh"

# All vector units that can be emulated: the vision library chooses its code, and so its last digits, by what it finds.
# One core, time counted in instructions: what happens in the guest does not depend on how busy this machine is.
timeout "$TIMEOUT_S" nice -n "${POLHODE_VM_NICE:-10}" qemu-system-x86_64 -M pc -m 1536 -nographic -no-reboot -nodefaults -serial stdio \
  -cpu max -smp 1 -accel tcg,thread=single -icount shift=2,sleep=off \
  -kernel "$KERNEL/boot/vmlinuz-$RELEASE" -initrd "$RESULTS/.initramfs.gz" \
  -append "console=ttyS0 quiet panic=-1 oops=panic mitigations=off random.trust_cpu=on" \
  -fsdev "local,id=host,path=/,security_model=none,readonly=on,multidevs=remap" \
  -device virtio-9p-pci,fsdev=host,mount_tag=host \
  -fsdev "local,id=results,path=$RESULTS,security_model=none" \
  -device virtio-9p-pci,fsdev=results,mount_tag=results \
  < /dev/null > "$RESULTS/boot.txt" 2>&1 || { echo "boot: the machine did not end by itself; see $RESULTS/boot.txt" >&2; exit 124; }
exit "$(cat "$RESULTS/status")"
