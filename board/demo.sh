#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The whole way on one PC, from images on: pictures of a board -> calibration -> a dry picture of the flume -> pose -> simulated
# flume -> srd-node -> datagrams on loopback -> srd listen -> estimated against true surface -> plots. Installs and builds what
# it needs.
set -euo pipefail

usage() { echo "usage: board/demo.sh [--frames N] [--out DIR]   (default: 200 frames, build/demo-DATE-TIME)"; }
fail() {
  echo "demo: $1" >&2
  exit "${2:-1}"
}

frames=200
out=
while [ $# -gt 0 ]; do
  case $1 in
    --frames | --out)
      [ $# -ge 2 ] || { usage >&2; exit 2; }
      if [ "$1" = --frames ]; then frames=$2; else out=$2; fi
      shift 2
      ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
done
[[ $frames =~ ^[1-9][0-9]{0,6}$ ]] || fail "--frames: expected a whole number from 1 to 9999999, found '$frames'" 2

# A folder given relative to where the person stands stays there.
case $out in "" | /*) ;; *) out=$PWD/$out ;; esac
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
[ -n "$out" ] || out=$PWD/build/demo-$(date +%Y%m%d-%H%M%S)
[ ! -e "$out/coefficients.csv" ] || fail "$out already holds a demo: give another --out" 2

tests/install_packages.sh
echo "== build"
cmake --preset host >/dev/null || fail "the configuration failed: run cmake --preset host"
cmake --build --preset host --target srd srd-node || fail "the build failed"
srd=build/host/host/srd
node=build/host/firmware/srd-node
mkdir -p -- "$out"

# A picture of the dry board from each of these places, by the camera of the flume: centre, target (mm), roll (degrees).
views=16
view_places() {
  awk -v n="$views" 'BEGIN {
    for (i = 0; i < n; ++i) {
      tilt = (20 + 12.5 * (i % 3)) * atan2(0, -1) / 180
      turn = 10 * atan2(0, -1) * i / n
      distance = 850 + 120 * (i % 4)
      x = 100 + 45 * cos(2.3 * i)
      y = 200 + 90 * sin(1.7 * i)
      printf "%.3f, %.3f, %.3f %.3f, %.3f, 0.0 %.2f\n", x + distance * sin(tilt) * cos(turn),
        y + distance * sin(tilt) * sin(turn), distance * cos(tilt), x, y, 8 * sin(i)
    }
  }'
}
render_view() { # number, centre_mm, target_mm, roll_deg
  local scene=$out/calibration/scene-$1.toml
  printf 'seed = %d\nframes = 1\n[pose]\ncentre_mm = [%s]\ntarget_mm = [%s]\nroll_deg = %s\n' "$((100 + 10#$1))" "$2" "$3" "$4" >"$scene"
  "$srd" simulate "$scene" --out "$out/calibration/scene-$1" >/dev/null &&
    mv -- "$out/calibration/scene-$1/reference.png" "$out/calibration/view-$1.png" &&
    rm -r -- "$out/calibration/scene-$1" "$scene"
}

echo "== $views pictures of a board, and the camera from them"
mkdir -p -- "$out/calibration"
rendering=()
while read -r x y z tx ty tz roll; do
  number=$(printf %02d "${#rendering[@]}")
  render_view "$number" "$x $y $z" "$tx $ty $tz" "$roll" &
  rendering+=($!)
  # No more at once than there are processors.
  [ "${#rendering[@]}" -lt "$(nproc)" ] || wait "${rendering[${#rendering[@]} - $(nproc)]}" || fail "srd simulate failed"
done < <(view_places)
for process in "${rendering[@]}"; do wait "$process" || fail "srd simulate failed"; done
"$srd" calibrate "$out"/calibration/view-*.png --board 21x11 --square-mm 20 --out "$out/calibration" ||
  fail "srd calibrate ended with code $?"

echo "== a picture of the dry flume, and where its camera is"
"$srd" simulate --frames 1 --out "$out/dry" >/dev/null || fail "srd simulate ended with code $?"
"$srd" pose "$out/dry/reference.png" --calibration "$out/calibration/calibration.yml" --pattern "$out/dry/points.txt" \
  --position 1 --depth 80 --out "$out/pose" || fail "srd pose ended with code $?"

# The node is told what was found, not what the simulator knows.
{
  cat board/simulator/node.toml
  printf '\n[geometry]\ncalibration = "calibration/calibration.yml"\npose = "pose/pose.yml"\npoints = "pose/points.txt"\n'
} >"$out/node.toml"

listener=
stop_listener() {
  if [ -n "$listener" ]; then
    kill "$listener" 2>/dev/null || true
    wait "$listener" 2>/dev/null || true
    listener=
  fi
}
trap stop_listener EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

port=$(python3 -c 'import socket; s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
echo "== $frames frames of the simulated flume over 127.0.0.1:$port"
"$srd" listen --bind "127.0.0.1:$port" --csv "$out/coefficients.csv" --count "$frames" \
  >"$out/listen.log" 2>&1 </dev/null &
listener=$!
"$node" --config "$out/node.toml" --camera simulator --host "127.0.0.1:$port" \
  --frames "$frames" --rate max --truth "$out/truth.csv" ||
  fail "srd-node ended with code $?; srd listen said: $(cat "$out/listen.log")"

# The node lingers until its last frame is acknowledged, so the listener has all it waits for: a minute is ample.
for ((tenths = 0; tenths < 600; ++tenths)); do
  kill -0 "$listener" 2>/dev/null || break
  sleep 0.1
done
! kill -0 "$listener" 2>/dev/null ||
  fail "srd listen still waits for frames a minute after the node ended; it said: $(cat "$out/listen.log")"
status=0
wait "$listener" || status=$?
listener=
[ "$status" -eq 0 ] || fail "srd listen ended with code $status: $(cat "$out/listen.log")"

echo "== estimated against true"
"$srd" compare "$out/coefficients.csv" "$out/truth.csv" || fail "srd compare ended with code $?"
echo "== plots"
"$srd" plot "$out/coefficients.csv" --truth "$out/truth.csv" --out "$out" >/dev/null || fail "srd plot ended with code $?"

echo "== written"
find "$out" -maxdepth 1 -type f | sort
