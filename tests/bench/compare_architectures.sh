#!/usr/bin/env bash
# The same frames on this machine and on 64-bit ARM (qemu): the front end must give the same numbers bit for bit, the
# surface over the pattern the same to 1e-3 mm. Builds what it needs, as count_instructions.sh does.
# usage: tests/bench/compare_architectures.sh [FRAMES]   (default 8)
set -euo pipefail

case ${1:-} in
  -h | --help) sed -n 's/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
esac
frames=${1:-8}
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
[ -d build/sysroots/debian12-arm64 ] || toolchains/sysroot.sh arm64 >&2
for preset in bench arm64-count; do
  [ -f "build/$preset/CMakeCache.txt" ] || cmake --preset "$preset" >&2
done
cmake --build build/bench --target srd_prerender frame_digest >&2
cmake --build build/arm64-count --target frame_digest >&2
sequence=build/arm64-count/frames-$frames.bin
build/bench/tests/bench/srd_prerender "$sequence" "$frames"
build/bench/tests/bench/frame_digest "$sequence" "$frames" >build/arm64-count/digest-here
QEMU_LD_PREFIX=build/sysroots/debian12-arm64 qemu-aarch64-static build/arm64-count/tests/bench/frame_digest "$sequence" "$frames" \
  >build/arm64-count/digest-arm64
python3 - build/arm64-count/digest-here build/arm64-count/digest-arm64 <<'PYTHON'
import sys

here, there = ([line.split() for line in open(name, encoding="ascii")] for name in sys.argv[1:])
worst, differing = 0.0, 0
for a, b in zip(here, there, strict=True):
    differing += a[:3] != b[:3]
    worst = max([worst] + [abs(float(x) - float(y)) for x, y in zip(a[4:], b[4:], strict=True)])
    assert len(a) > 4, "a frame without a surface"
print(f"{len(here)} frames, {sum(int(a[1]) for a in here)} corners: front end differs in {differing} frames; "
      f"surfaces differ by at most {worst:.6f} mm")
sys.exit(differing > 0 or worst > 1e-3)
PYTHON
