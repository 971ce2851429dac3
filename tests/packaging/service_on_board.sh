#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The packaged service under systemd on the emulated board, with its camera (vivid) and its strobe line (gpio-sim): the unit's
# sandbox lets through what the node needs, and nothing is left lit. Checks: service_checks.sh.
# Builds what is missing. Needs: root. Exit code 0 only when every check passed.
set -euo pipefail
case ${1:-} in
  "") ;;
  *) echo "usage: tests/packaging/service_on_board.sh"; [ "$1" = --help ] || [ "$1" = -h ]; exit ;;
esac
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
. toolchains/debian_packages.sh
. toolchains/kept.sh
. toolchains/build_preset.sh
. toolchains/emulated_root.sh
[ "$(id -u)" -eq 0 ] || { echo "service_on_board: making a Debian system needs root." >&2; exit 2; }
build_preset arm64 srd-node
[ -d build/virtual-board ] || toolchains/virtual_board/build.sh
know_interpreter arm64 || { echo "service_on_board: the kernel does not run arm64 programs (binfmt_misc, qemu-user-static)" >&2; exit 2; }

roots=$PWD/build/roots
work=$roots/board
system=$roots/debian12-arm64-systemd.tar
make_root arm64 12
rm -rf "$work" "$roots/board-tree"
mkdir -p "$work/geometry" "$roots/board-tree"
trap 'forget_interpreter; rm -rf --one-file-system "$roots/board-tree"' EXIT

(cd build/arm64 && rm -f packages/*.deb && cpack -G DEB -B packages >packages.log 2>&1) || { cat build/arm64/packages.log; exit 1; }
cp build/arm64/packages/flume-srd-node_*_arm64.deb "$work/node.deb"
python3 tests/packaging/write_geometry.py board/virtual/node.toml "$work/geometry"
cp tests/packaging/service_checks.sh tests/check.sh "$work/"

# A system with systemd is made once; the package of this build is installed each time.
tree=$roots/board-tree
tar -C "$tree" -xf "$([ -s "$system" ] && echo "$system" || echo "$root_tar")"
apt="apt-get -qq -y --no-install-recommends"
if [ ! -s "$system" ]; then
  in_emulated_root "$tree" "$root_archives" env DEBIAN_FRONTEND=noninteractive \
    sh -c "$apt install systemd-sysv udev kmod gpiod </dev/null" >"$roots/board.log" 2>&1 || { tail -n 30 "$roots/board.log"; exit 1; }
  tar -C "$tree" -cf "$system.part" . && mv "$system.part" "$system"
fi
cp "$work/node.deb" "$tree/node.deb"
in_emulated_root "$tree" "$root_archives" env DEBIAN_FRONTEND=noninteractive \
  sh -c "$apt install /node.deb </dev/null" >"$roots/board.log" 2>&1 || { tail -n 30 "$roots/board.log"; exit 1; }
rm "$tree/node.deb"
cat >"$tree/etc/systemd/system/checks.service" <<'UNIT'
[Unit]
DefaultDependencies=no
After=basic.target systemd-udevd.service
[Service]
Type=oneshot
ExecStart=/bin/sh -c '/bin/sh /w/service_checks.sh; echo $? >/w/exit_code; sync; systemctl poweroff -ff'
StandardOutput=tty
StandardError=tty
TTYPath=/dev/console
UNIT
ln -s ../checks.service "$tree/etc/systemd/system/multi-user.target.wants/checks.service"
# systemd is to be there first: the checks load the drivers.
rm -f "$tree/etc/systemd/system/getty.target.wants/"*
mke2fs -q -t ext4 -O ^has_journal -m 0 -d "$tree" "$work.ext4.part" 1200M
mv "$work.ext4.part" "$work.ext4"
BOARD_ROOT=$work.ext4 BOARD_INIT=/usr/lib/systemd/systemd toolchains/virtual_board/boot.sh "$work" 300
