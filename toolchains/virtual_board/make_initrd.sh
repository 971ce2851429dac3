#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# initrd.gz: busybox, the modules that the board loads, and init.sh.
# usage: make_initrd.sh FOLDER INIT; FOLDER has kernel/, modules/ and root/
set -euo pipefail
cd -- "$1"
init=$2
wanted=(virtio_pci virtio_mmio virtio_net virtio_blk 9pnet_virtio 9p overlay ext4 crc32c_generic libcrc32c configfs sch_netem
  vivid vimc irq_sim gpio-sim)

version=$(ls kernel/lib/modules)
from=kernel/lib/modules/$version
mkdir -p "$from/extra"
find modules -name '*.ko' -exec cp -t "$from/extra" {} +
/sbin/depmod -b kernel "$version"

tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
mkdir -p "$tree"/{bin,proc,sys,dev,r}
cp root/bin/busybox "$tree/bin/busybox"
for module in "${wanted[@]}"; do
  /sbin/modprobe -d kernel -S "$version" --show-depends "$module" | awk '$1 == "insmod" {print $2}'
done | sort -u | while read -r file; do
  to=$tree/lib/modules/$version/${file#*"$version"/}
  mkdir -p "$(dirname "$to")"
  case $file in
    *.xz) to=${to%.xz}; xz -dc "$file" >"$to" ;;
    *) cp "$file" "$to" ;;
  esac
  aarch64-linux-gnu-strip --strip-debug "$to"
done
cp "$from"/modules.builtin* "$from/modules.order" "$tree/lib/modules/$version/"
/sbin/depmod -b "$tree" "$version"
install -m 755 "$init" "$tree/init"
(cd "$tree" && find . | cpio -o -H newc --quiet | gzip -1) >initrd.gz
