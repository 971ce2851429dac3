#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Prints the name of the profile that fits this board, by what the firmware calls it.
set -eu
model=$(tr -d '\000' 2>/dev/null <"${SRD_MODEL_FILE:-/proc/device-tree/model}" || true)
case $model in
  "Raspberry Pi 4"* | "Raspberry Pi Compute Module 4"*) echo raspberrypi-4 ;;
  "Raspberry Pi 5"* | "Raspberry Pi Compute Module 5"*) echo raspberrypi-5 ;;
  *) echo generic-v4l2 ;;
esac
