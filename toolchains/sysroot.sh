#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Unpacks what building for a board needs into build/sysroots/debian<RELEASE>-<ARCHITECTURE>. Kept between clones (kept.sh).
# Then: cmake --workflow --preset arm64 (armhf, arm64-debian13)
set -euo pipefail

usage() { echo "usage: toolchains/sysroot.sh arm64|armhf|amd64 [--debian 12|13]"; }

packages=(
  libc6-dev libstdc++-12-dev libeigen3-dev libhwy-dev libjpeg62-turbo-dev libnanopb-dev libopencv-core-dev libpng-dev libtomlplusplus-dev
  libcli11-dev libcamera-dev libgpiod-dev libsodium-dev libsystemd-dev
  # of the tests
  libgtest-dev librapidcheck-dev libprotobuf-dev)

architecture=
release=12
while [ $# -gt 0 ]; do
  case $1 in
    arm64 | armhf | amd64) architecture=$1 ;;
    --debian) release=${2:?--debian: 12 or 13}; shift ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
  shift
done
[ -n "$architecture" ] || { usage >&2; exit 2; }

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
. toolchains/debian_packages.sh
. toolchains/kept.sh
to=$PWD/build/sysroots/debian$release-$architecture
kept=$(kept_path "sysroot-debian$release-$architecture" toolchains/sysroot.sh toolchains/debian_packages.sh)
# Whole or not there: an interrupted run leaves nothing that looks finished.
if [ ! -d "$kept" ]; then
  part=$(mktemp -d "$kept_folder/part.XXXXXX")
  trap 'rm -rf -- "$part"' EXIT
  debian_packages "$part" "$release" "$architecture" "${packages[@]}"
  chmod 755 "$part"
  keep "$part" "$kept"
fi
from_kept "$kept" "$to"
echo "$to: $(du -sh "$to" | cut -f1)"
