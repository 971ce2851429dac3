#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes an emulated 64-bit ARM board with real kernel drivers in build/virtual-board: Debian 12's kernel with vivid (cameras),
# vimc (libcamera's camera) and gpio-sim (GPIO lines), an initrd, and root images with what srd-node needs to run on
# Debian 12 and 13. Nothing is installed; no root needed. Kept between clones (kept.sh). boot.sh starts it.
# Needs: toolchains/packages.txt.
set -euo pipefail

case ${1:-} in
  "") ;;
  *) echo "usage: toolchains/virtual_board/build.sh"; [ "$1" = --help ] || [ "$1" = -h ]; exit ;;
esac
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
. toolchains/debian_packages.sh
. toolchains/kept.sh
here=$PWD/toolchains/virtual_board
to=$PWD/build/virtual-board
kept=$(kept_path virtual-board toolchains/debian_packages.sh "$here"/{build,build_modules,init,make_initrd}.sh)
give() {
  from_kept "$kept" "$to"
  echo "$to: $(du -sh "$to" | cut -f1)"
}
[ ! -d "$kept" ] || { give; exit 0; }
# Not below build: the kernel's makefiles do not take a folder with a space in its name.
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd "$work"

# What runs on the board, besides the project's own programs and their libraries.
runtime=(bash coreutils grep kmod udev iproute2 busybox-static v4l-utils gpiod libcamera-ipa)
debian_packages "$PWD/root" 12 arm64 "${runtime[@]}" libcamera0.0.3 libgpiod2 libhwy1 libjpeg62-turbo libsodium23 libopencv-core406 libpng16-16 libsystemd0 &
root_job=$!
debian_packages "$PWD/root13" 13 arm64 bash coreutils libcamera0.4 libcamera-ipa libgpiod3 libhwy1t64 libopencv-core410 \
  libjpeg62-turbo libsodium23 libpng16-16t64 libsystemd0 gpiod &
root13_job=$!

debian_state "$PWD/state" 12 arm64
apt=(apt-get -c "$PWD/state/apt.conf" -qq)
image=$(apt-cache -c "$PWD/state/apt.conf" depends linux-image-arm64 | awk '/Depends/ {print $2; exit}')
version=${image#linux-image-}
version=${version%-arm64}
(cd state && "${apt[@]}" download "$image" "linux-headers-$version-arm64" "linux-headers-$version-common" linux-source-6.1)
# kbuild's programs run on this machine.
debian_state "$PWD/state-here" 12 "$(dpkg --print-architecture)"
(cd state && apt-get -c ../state-here/apt.conf -qq download linux-kbuild-6.1)
dpkg-deb -x state/"$image"_*.deb kernel
for package in state/linux-headers-*.deb state/linux-kbuild-*.deb; do dpkg-deb -x "$package" headers; done
dpkg-deb --fsys-tarfile state/linux-source-6.1_*.deb | tar -xO ./usr/src/linux-source-6.1.tar.xz | xz -dc -T2 |
  tar -x linux-source-6.1/drivers/media/test-drivers/vimc linux-source-6.1/drivers/gpio linux-source-6.1/kernel/irq

"$here/build_modules.sh" "$PWD" "$version" >modules.log 2>&1 || { tail -n 30 modules.log >&2; exit 1; }
wait "$root_job"
"$here/make_initrd.sh" "$PWD" "$here/init.sh"
cp kernel/boot/vmlinuz-* vmlinuz
wait "$root13_job"
mke2fs -q -t ext4 -O ^has_journal -m 0 -d root root.ext4 1G
mke2fs -q -t ext4 -O ^has_journal -m 0 -d root13 root13.ext4 1G
mkdir whole
mv vmlinuz initrd.gz root.ext4 root13.ext4 whole
rm -rf -- "$kept.part"
mv whole "$kept.part"
keep "$kept.part" "$kept"
give
