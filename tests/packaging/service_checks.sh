#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs on the emulated board under systemd, as root: what a technician does after installing, and what must not happen.
set -u
node=/etc/flume-srd/node.toml
unit=flume-srd-node
# shellcheck source=tests/check.sh
. /w/check.sh

comes_to() { # state; an emulated board takes its time
  for _ in $(seq 30); do
    [ "$(systemctl show -P ActiveState $unit)" != "$1" ] || return 0
    sleep 1
  done
  systemctl show -P ActiveState $unit
  false
}
result_is() { systemctl show -P Result $unit; [ "$(systemctl show -P Result $unit)" = "$1" ]; }
said() { journalctl -q --no-pager -u $unit | grep -F -- "$1" || { journalctl -q --no-pager -u $unit | tail -n 30; false; }; }
line() { cat /sys/devices/platform/gpio-sim.*/gpiochip*/sim_gpio3/value; }
is_dark() { [ "$(line)" = 0 ]; }
main_pid() { systemctl show -P MainPID $unit; }
threads_have() { # policy and priority
  for thread in /proc/"$(main_pid)"/task/*; do chrt -p "${thread##*/}"; done | tee /tmp/threads | grep -q "$1" || { cat /tmp/threads; false; }
}
status_has() { grep -E "$1" /proc/"$(main_pid)"/status || { cat /proc/"$(main_pid)"/status; false; }; }
toggles() { # the line is seen high and low
  seen=
  for _ in $(seq 400); do
    case $(line) in
      1) seen=${seen}h ;;
      0) seen=${seen}l ;;
    esac
    case $seen in *h*l* | *l*h*) return 0 ;; esac
  done
  false
}
restarted() {
  for _ in $(seq 30); do
    [ "$(systemctl show -P NRestarts $unit)" -eq 0 ] || { comes_to active; return; }
    sleep 1
  done
  false
}
only_its_folder() { # as the service sees files
  nsenter -t "$(main_pid)" -m sh -c '! touch /etc/written 2>/dev/null && ! touch /usr/written 2>/dev/null && touch /var/lib/flume-srd/written'
}
doctor_has_the_services_rights() { # by the command that the documents name; that nobody answers on the host is its own matter
  prlimit --rtprio=90 --memlock=unlimited setpriv --reuid=flume-srd --regid=flume-srd --init-groups \
    srd-node --config $node --doctor >/tmp/doctor 2>&1
  cat /tmp/doctor
  for subject in priority memory groups GPIO; do grep -qE "^OK +$subject" /tmp/doctor || return 1; done
}

check "unedited: the service is skipped" comes_to inactive
check "unedited: it says what to do" said "edit node.id and node.host"

modprobe vivid n_devs=1
modprobe gpio-sim
bank=/sys/kernel/config/gpio-sim/board/bank0
mountpoint -q /sys/kernel/config || mount -t configfs configfs /sys/kernel/config
mkdir -p $bank/line3
echo 8 >$bank/num_lines
echo strobe >$bank/line3/name
echo 1 >/sys/kernel/config/gpio-sim/board/live
udevadm settle

sed -e 's/^id = .*/id = "board"/' -e 's/^host = .*/host = "127.0.0.1:47810"/' /usr/share/flume-srd/profiles/virtual/node.toml >$node
cp /w/geometry/*.yml /etc/flume-srd/
check "doctor has the service's rights" doctor_has_the_services_rights
check "starts" systemctl start $unit
sleep 5
check "runs" comes_to active
[ "$(main_pid)" -gt 0 ] || { journalctl -q --no-pager -u $unit; exit 1; }
check "sends frames" sh -c 'systemctl status flume-srd-node | grep -E "frames/s"'
check "has real-time priority" threads_have "SCHED_FIFO"
check "has locked memory" status_has 'VmLck:[[:space:]]+[1-9][0-9]{3,} kB'
check "has no capability" status_has 'CapEff:[[:space:]]+0+$'
check "writes to its folder only" only_its_folder
check "strobe line toggles" toggles

kill -KILL "$(main_pid)"
sleep 1
check "killed: the line is low" is_dark
check "killed: started again" restarted

check "stops" systemctl stop $unit
check "stopped: the line is low" is_dark
check "stopped, host away: no failure" result_is success

echo 'unknown = 1' >>$node
check "wrong configuration: does not start" sh -c '! systemctl start flume-srd-node'
check "wrong configuration: not tried again" comes_to failed
check "wrong configuration: the line is named" said "unknown key"

# The whole journal of the service, for whoever reads a failure.
[ $failed -eq 0 ] || journalctl -q --no-pager -u $unit
exit "$failed"
