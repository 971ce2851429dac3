#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Ends with 0 when a node's configuration was edited: it is none of the profiles that wait for a person to do so.
set -eu
config=${1:?usage: configured FILE}
profiles=${SRD_PROFILES:-/usr/share/flume-srd/profiles}
if [ ! -r "$config" ]; then
  echo "flume-srd-node: no $config: copy a profile from $profiles" >&2
  exit 1
fi
for board in raspberrypi-4 raspberrypi-5 generic-v4l2; do
  if cmp -s "$config" "$profiles/$board/node.toml"; then
    echo "flume-srd-node: edit node.id and node.host in $config, put calibration.yml and pose.yml beside it, then, as root: prlimit --rtprio=90 --memlock=unlimited setpriv --reuid=flume-srd --regid=flume-srd --init-groups srd-node --config $config --doctor && systemctl start flume-srd-node" >&2
    exit 1
  fi
done
