#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The same frames on this machine and on ARM (qemu): the front end must give the same numbers bit for bit, the surface over
# the pattern the same to 1e-3 mm. Builds what it needs with the presets host and arm64 or armhf.
# usage: tests/bench/compare_architectures.sh [arm64|armhf|arm64-debian13] [FRAMES]   (default arm64, 8)
set -euo pipefail

case ${1:-} in
  -h | --help) sed -n '/^# SPDX/d; s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
esac
board=${1:-arm64}
frames=${2:-8}
case $board in
  arm64) sysroot=debian12-arm64 emulator=qemu-aarch64-static ;;
  armhf) sysroot=debian12-armhf emulator=qemu-arm-static ;;
  arm64-debian13) sysroot=debian13-arm64 emulator=qemu-aarch64-static ;;
  *) echo "compare_architectures.sh: no board '$board': arm64, armhf or arm64-debian13" >&2; exit 2 ;;
esac
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
. toolchains/build_preset.sh
build_preset host srd_prerender frame_digest
build_preset "$board" frame_digest
sequence=build/$board/frames-$frames.bin
build/host/tests/bench/srd_prerender "$sequence" "$frames"
build/host/tests/bench/frame_digest "$sequence" "$frames" >"build/$board/digest-here"
QEMU_LD_PREFIX=build/sysroots/$sysroot "$emulator" "build/$board/tests/bench/frame_digest" "$sequence" "$frames" \
  >"build/$board/digest-there"
python3 - "build/$board/digest-here" "build/$board/digest-there" "$board" <<'PYTHON'
import sys

here, there = ([line.split() for line in open(name, encoding="ascii")] for name in sys.argv[1:3])
worst, differing = 0.0, 0
for a, b in zip(here, there, strict=True):
    differing += a[:3] != b[:3]
    worst = max([worst] + [abs(float(x) - float(y)) for x, y in zip(a[4:], b[4:], strict=True)])
    assert len(a) > 4, "a frame without a surface"
print(f"{sys.argv[3]}: {len(here)} frames, {sum(int(a[1]) for a in here)} corners: front end differs in {differing} frames; "
      f"surfaces differ by at most {worst:.6f} mm")
sys.exit(differing > 0 or worst > 1e-3)
PYTHON
