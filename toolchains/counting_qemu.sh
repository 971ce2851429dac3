#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Unpacks a qemu that takes plugins into build/counting-qemu: Debian's static one takes none, and installing the other
# would replace it.
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
. toolchains/debian_packages.sh
to=$PWD/build/counting-qemu
rm -rf -- "$to" "$to.part"
debian_packages "$to.part" 12 "$(dpkg --print-architecture)" qemu-user libcapstone4 liburing2
mv -- "$to.part" "$to"
echo "$to: $(du -sh "$to" | cut -f1)"
