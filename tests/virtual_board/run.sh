#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The instrument on an emulated 64-bit ARM board with real kernel drivers: cross-builds srd-node, boots the board, plays
# rendered water through vivid's output and capture devices, receives the records on this machine through the board's network
# card with losses, and compares with the truth. Builds what is missing. Ends with 0 when every check held.
set -euo pipefail

usage() { echo "usage: tests/virtual_board/run.sh [--debian13]   (also the drivers as built for Debian 13)"; }
debian13=false
for argument in "$@"; do
  case $argument in
    --debian13) debian13=true ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
done
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
. toolchains/build_preset.sh
started=$SECONDS
tests/install_packages.sh toolchains/packages.txt

[ -d build/virtual-board ] || toolchains/virtual_board/build.sh
build_preset host srd
build_preset arm64 srd-node srd_board_tests
! $debian13 || build_preset arm64-debian13 srd_board_tests
echo "== built after $((SECONDS - started)) s"

here=tests/virtual_board
work=$PWD/build/virtual-board-run
srd=$PWD/build/host/host/srd
rm -rf -- "$work"
mkdir -p "$work/node" "$work/data"
"$srd" simulate "$here/flume.toml" --pgm --out "$work/flume" >/dev/null
python3 -B "$here/marked_frames.py" play "$work/flume" "$work/frames.raw"
# The board's own profile, with the geometry of the scene beside it, as a person would put it there.
sed 's/^id = [^#]*/id = "calm" /' board/virtual/node.toml >"$work/node/node.toml"
printf '\n[record]\nmin_free_mib = 64\n' >>"$work/node/node.toml"  # the board's disk is its memory
cp "$work/flume/calibration.yml" "$work/flume/pose.yml" "$work/node/"
# vimc gives 636 x 480: the same camera, four columns narrower. It sees no flume.
sed 's/^image_width:.*/image_width: 636/' "$work/flume/calibration.yml" >"$work/node/vimc-calibration.yml"
cat >"$work/node/vimc.toml" <<'TOML'
[node]
id = "vimc"
[camera]
source = "libcamera"
[geometry]
calibration = "vimc-calibration.yml"
pose = "pose.yml"
[pattern]
rows = 11
columns = 21
square_mm = 20
[surface]
lx_mm = 240
ly_mm = 440
guess_mm = [80.0]
TOML
cp -r tests/data/flume-small "$work/data/"
cp "$here/on_board.sh" tests/check.sh "$work/"
for program in firmware/srd-node tests/srd_board_tests; do
  aarch64-linux-gnu-strip -o "$work/${program##*/}" "build/arm64/$program"
done
if $debian13; then aarch64-linux-gnu-strip -o "$work/srd_board_tests-debian13" build/arm64-debian13/tests/srd_board_tests; fi

port=$(python3 -c 'import socket; s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
printf 'NODE_HOST=10.0.2.2:%s\n' "$port" >"$work/settings"
"$srd" listen --bind "127.0.0.1:$port" --csv "$work/coefficients.csv" >"$work/listen.log" 2>&1 </dev/null &
listener=$!
trap 'kill "$listener" 2>/dev/null || true' EXIT
check_shows=always
. tests/check.sh
echo "== board"
toolchains/virtual_board/boot.sh "$work" 300 || failed=$?
sleep 1
kill -INT "$listener"
wait "$listener" || true
trap - EXIT

echo "== on this machine"
tail -n 3 "$work/listen.log"
# Late frames have no record: the node's own number of records is what the host must have.
records() { sed -n 's/^frames .* captured, \([0-9]*\) records.*/\1/p' "$work/$1.log"; }
rows() { awk -F, -v node="$1" '$1 == node {rows++} END {print rows + 0}' "$work/coefficients.csv"; }
surfaces() { awk -F, -v node="$1" '$1 == node && $6 == "ok" {rows++} END {print rows + 0}' "$work/coefficients.csv"; }
for node in vimc calm troubled; do
  check "every record of $node is in the host's once: $(rows $node)" [ "$(rows $node)" = "$(records $node)" ]
done
tar -C "$work" -xf "$work/recorded.tar" || failed=1
# Of the records that the emulator's speed allowed; after a fault the pattern is searched again.
for run in calm:95 troubled:80; do
  node=${run%:*}
  check "$node: at least ${run#*:} % of the records have a surface, and 100: $(surfaces "$node") of $(rows "$node")" \
    [ "$(surfaces "$node")" -ge 100 -a $((100 * $(surfaces "$node"))) -ge $((${run#*:} * $(rows "$node"))) ]
  check "$node: recorded frames carry their marks" \
    python3 -B "$here/marked_frames.py" truth "$work/$node" "$work/flume/truth.csv" "$work/$node-truth.csv"
  check "$node: surfaces are within 0.1 mm of the truth" \
    "$srd" compare --node "$node" --max-rms 0.1 "$work/coefficients.csv" "$work/$node-truth.csv"
done
check "the strobe is in step with the frames" python3 -B "$here/check_strobe.py" "$work/gpio.trace" "$work/calm/frames.csv"
echo "== virtual board: $([ "$failed" -eq 0 ] && echo passed || echo "FAILED ($failed)") after $((SECONDS - started)) s"
rm -f -- "$check_said"
exit "$failed"
