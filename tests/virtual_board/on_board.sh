#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs on the emulated board as root, in /w. Ends with 0 when every step did; says what each saw.
set -u
# shellcheck source=tests/check.sh
. /w/check.sh
step() { echo "-- $*"; }
# shellcheck source=/dev/null
. /w/settings # NODE_HOST

/lib/systemd/systemd-udevd --daemon 2>/dev/null
mkdir -p /var/lib/flume-srd /run/srd
cp /w/srd-node /w/srd_board_tests /run/srd/
cp -r /w/data /w/node /run/srd/
mount -t tracefs trace /sys/kernel/tracing 2>/dev/null
export SRD_BOARD_DATA=/run/srd/data LIBCAMERA_LOG_LEVELS='*:WARN'
cd /run/srd || exit 1

step "drivers against the kernel, Debian 12"
modprobe vivid n_devs=2 multiplanar=1,2 node_types=0x101,0x1 num_inputs=2,1 input_types=0xc,0 num_outputs=1 output_types=1
modprobe vimc
modprobe gpio-sim
udevadm trigger
udevadm settle
/run/srd/srd_board_tests >/w/board_tests.log 2>&1
code=$?
grep -E "^\[  (PASSED|SKIPPED|FAILED)|^strobe|lateness|page fault|allocation" /w/board_tests.log
check "board tests, Debian 12: none failed" [ "$code" -eq 0 ]
check "board tests, Debian 12: none skipped" bash -c "! grep -q '^\[  SKIPPED' /w/board_tests.log"
check "srd-node --list-cameras sees vivid and vimc" bash -c \
  "./srd-node --list-cameras 2>/dev/null | tee /w/list_cameras.log | grep -q vivid && grep -qi vimc /w/list_cameras.log"

if [ -x /w/srd_board_tests-debian13 ]; then
  step "drivers against the kernel, Debian 13 (libgpiod 2, libcamera 0.4)"
  cp /w/srd_board_tests-debian13 /run/srd/
  chroot /debian13 /bin/bash -c "export SRD_BOARD_DATA=$SRD_BOARD_DATA LD_LIBRARY_PATH=/usr/lib/aarch64-linux-gnu/blas:/usr/lib/aarch64-linux-gnu/lapack; \
    /run/srd/srd_board_tests-debian13 --gtest_filter='*Gpio*:*Libcamera*'" >/w/board_tests-debian13.log 2>&1
  code=$?
  grep -E "^\[  (PASSED|SKIPPED|FAILED)" /w/board_tests-debian13.log
  check "board tests, Debian 13: none failed" [ "$code" -eq 0 ]
  check "board tests, Debian 13: none skipped" bash -c "! grep -q '^\[  SKIPPED' /w/board_tests-debian13.log"
fi

step "network: 20 % of what the board sends is lost"
tc qdisc replace dev eth0 root netem loss 20% delay 5ms 2ms
tc qdisc show dev eth0

step "libcamera's camera through the frame loop"
./srd-node --config node/vimc.toml --host "$NODE_HOST" --frames 60 >/w/vimc.log 2>&1
code=$?
cat /w/vimc.log
# It sees no flume: the host counts that all its records came.
check "vimc: a run without a surface ends with 3 and says so" bash -c "[ $code -eq 3 ] && grep -q 'nothing was measured' /w/vimc.log"
rmmod vimc vivid

step "the flume through vivid, with the strobe"
modprobe vivid n_devs=1 node_types=0x101
udevadm settle
line=/sys/kernel/config/gpio-sim/board
mkdir -p $line/bank0/line0
echo strobe >$line/bank0/line0/name
echo 1 >$line/live
video="v4l2-ctl -d /dev/video0"
timings=index=0 # 640 x 480 at 59.94 Hz
$video --set-input=3 && $video --set-dv-bt-timings "$timings" &&
  $video --set-fmt-video=pixelformat=GREY
v4l2-ctl -d /dev/video1 --set-output=1
v4l2-ctl -d /dev/video1 --set-dv-bt-timings "$timings" && $video --set-ctrl=loop_video=1
$video --get-dv-timings | grep -E "Active|frames per second"
cp /w/frames.raw /tmp/frames.raw
# A disconnect ends the player as it ends the camera: it starts again.
(
  while [ ! -e /tmp/stop_player ]; do
    v4l2-ctl -d /dev/video1 --set-fmt-video-out=width=640,height=480,pixelformat=GREY --stream-out-mmap --stream-loop \
      --stream-from=/tmp/frames.raw >/dev/null 2>&1 &
    echo $! >/tmp/player.id
    wait
    sleep 0.3
  done
) &
player=$!
sleep 1.5
trace=/sys/kernel/tracing
echo mono >$trace/trace_clock
echo 16384 >$trace/buffer_size_kb
echo 1 >$trace/events/gpio/gpio_value/enable
./srd-node --config node/node.toml --host "$NODE_HOST" --frames 400 --record /tmp/calm >/w/calm.log 2>&1
code=$?
cat /w/calm.log
echo 0 >$trace/tracing_on
cat $trace/trace >/w/gpio.trace
check "calm: all acknowledged" [ "$code" -eq 0 ]
check "calm: no page fault in the frame loop" bash -c "! grep -q 'page faults' /w/calm.log"
check "strobe low at the end" [ "$(cat /sys/devices/platform/gpio-sim.0/gpiochip*/sim_gpio0/value)" = 0 ]

step "the same with dropped buffers, marked buffers, a fatal error and a disconnect"
sed -i 's/^id = .*/id = "troubled"/' node/node.toml
./srd-node --config node/node.toml --host "$NODE_HOST" --record /tmp/troubled >/w/troubled.log 2>&1 &
node=$!
(
  sleep 3
  $video --set-ctrl=percentage_of_dropped_buffers=40
  sleep 1.5
  $video --set-ctrl=percentage_of_dropped_buffers=0
  # The output device takes such an error as often as the capture device does.
  for _ in $(seq 36); do $video --set-ctrl=inject_v4l2_buf_flag_error=1; sleep 0.1; done
  sleep 1
  $video --set-ctrl=inject_fatal_streaming_error=1
  sleep 2
  $video --set-ctrl=disconnect=1
  sleep 5
  kill -INT $node
) >/w/faults.log 2>&1 &
faults=$!
wait $node
code=$?
cat /w/troubled.log
touch /tmp/stop_player
kill "$(cat /tmp/player.id)"
wait $player
wait $faults
check "troubled: all acknowledged, one run" [ "$code" -eq 0 ]
for fault in "gaps:[1-9][0-9]* by the source" "marked buffers:[1-9][0-9]* error buffers" "disconnects:[2-9] disconnects" \
  "returns:[2-9] reconnects"; do
  check "troubled: ${fault%%:*} counted" grep -qE "${fault#*:}" /w/troubled.log
done
tar -C /tmp -cf /w/recorded.tar calm troubled
exit "$failed"
