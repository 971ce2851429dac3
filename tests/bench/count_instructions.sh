#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Instructions that one tracked frame takes on 64-bit ARM, from camera buffer to datagram: (2N frames - N frames) / N in
# qemu, the same on every machine. Builds what it needs; toolchains/sysroot.sh makes the sysroot on the first run.
# usage: tests/bench/count_instructions.sh [--by-function] [N]   (default 16; a frame of the sequence is 2 MB of memory)
set -euo pipefail

by_function=false
case ${1:-} in
  --by-function) by_function=true; shift ;;
  -h | --help) sed -n '/^# SPDX/d; s/^# //p' "${BASH_SOURCE[0]}"; exit 0 ;;
esac
frames=${1:-16}
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
. toolchains/build_preset.sh
[ -d build/counting-qemu ] || toolchains/counting_qemu.sh >&2
build_preset bench srd_prerender
build_preset arm64-count frame_instructions

plugin=build/arm64-count/instruction_count.so
[ "$plugin" -nt toolchains/instruction_count.c ] || gcc -O2 -shared -fPIC -o "$plugin" toolchains/instruction_count.c
sequence=build/arm64-count/frames-$((2 * frames)).bin
[ "$sequence" -nt build/bench/tests/bench/srd_prerender ] ||
  build/bench/tests/bench/srd_prerender "$sequence" $((2 * frames))

# qemu-user runs with the C library that was unpacked beside it.
qemu=build/counting-qemu
loader=$(find "$qemu" -name 'ld-linux-*.so.*' | head -n 1)
libraries=$(find "$qemu" -name 'libc.so.6' -printf '%h\n' | head -n 1)
usr_libraries=$(find "$qemu" -name 'libglib-2.0.so.0' -printf '%h\n' | head -n 1)
count() {
  INSTRUCTION_COUNT=$plugin.$1 QEMU_LD_PREFIX=build/sysroots/debian12-arm64 \
    "$loader" --library-path "$libraries:$usr_libraries" "$qemu/usr/bin/qemu-aarch64" -plugin "$PWD/$plugin" \
    build/arm64-count/tests/bench/frame_instructions "$sequence" "$1" >&2
  head -n 1 "$plugin.$1"
}
once=$(count "$frames")
twice=$(count $((2 * frames)))
echo "$(((twice - once) / frames)) instructions a frame"
if $by_function; then
  tests/bench/instructions_by_function.py build/arm64-count/tests/bench/frame_instructions \
    "$plugin.$frames" "$plugin.$((2 * frames))" "$frames"
fi
