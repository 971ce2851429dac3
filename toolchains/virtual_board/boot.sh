#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Boots the emulated board, runs WORK/on_board.sh there as root (WORK is /w) and exits with its code; 125: it did not end in
# time. WORK/console.log keeps what the board printed. Its network card sees this machine as 10.0.2.2.
# usage: toolchains/virtual_board/boot.sh WORK [SECONDS]
# BOARD_ROOT: another root image; BOARD_INIT: its first process, which is then to write WORK/exit_code and to switch off.
set -euo pipefail
case ${1:-} in
  "" | -h | --help) sed -n '/^# SPDX/d; s/^# //p' "${BASH_SOURCE[0]}"; [ -n "${1:-}" ] || exit 2; exit 0 ;;
esac
work=$(readlink -m "$1")
limit=${2:-240}
board=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)/build/virtual-board
[ -f "$board/root.ext4" ] || { echo "boot.sh: no board in $board: run toolchains/virtual_board/build.sh" >&2; exit 2; }
rm -f -- "$work/exit_code"
timeout "$limit" qemu-system-aarch64 -M virt -accel tcg,thread=multi -cpu cortex-a72 -smp 2 -m 2048 -nographic -no-reboot \
  -netdev user,id=net -device virtio-net-pci,netdev=net,romfile= \
  -kernel "$board/vmlinuz" -initrd "$board/initrd.gz" -append "console=ttyAMA0 panic=-1 quiet${BOARD_INIT:+ BOARD_INIT=$BOARD_INIT systemd.show_status=0}" \
  -drive "file=${BOARD_ROOT:-$board/root.ext4},format=raw,if=virtio,readonly=on" \
  -drive "file=$board/root13.ext4,format=raw,if=virtio,readonly=on" \
  -virtfs "local,path=$work,mount_tag=work,security_model=none,multidevs=remap" \
  </dev/null 2>&1 | tr -d '\r' | tee "$work/console.log" || true
[ -f "$work/exit_code" ] || { echo "boot.sh: the board ended without a code, or not within $limit s (see above)" >&2; exit 125; }
exit "$(cat "$work/exit_code")"
