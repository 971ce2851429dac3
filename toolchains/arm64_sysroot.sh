#!/usr/bin/env bash
# Unpacks what cross building for 64-bit ARM needs into build/arm64-sysroot (or the folder given), and a qemu that takes
# plugins into build/arm64-qemu. Nothing is installed, no foreign architecture is added to the machine; no root needed.
# Needs from the machine: g++-aarch64-linux-gnu, apt-get and a Debian 12 package source.
set -euo pipefail

packages=(libc6-dev libstdc++-12-dev libeigen3-dev libnanopb-dev libhwy-dev)
emulator=(qemu-user libcapstone4 liburing2)

case ${1:-} in
  -h | --help) echo "usage: toolchains/arm64_sysroot.sh [FOLDER]"; exit 0 ;;
esac
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
sysroot=$(readlink -m "${1:-build/arm64-sysroot}")
qemu=$(dirname "$sysroot")/arm64-qemu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# A package state of its own, that knows nothing of this machine's packages: every dependency is unpacked.
fetch() {
  local architecture=$1 to=$2 state=$work/$1
  shift 2
  mkdir -p "$state"/etc/preferences.d "$state"/lists/partial "$state"/cache/archives/partial "$state"/log
  : >"$state/status"
  cat >"$state/apt.conf" <<CONF
APT::Architecture "$architecture";
APT::Architectures { "$architecture"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Dir::Etc::preferencesparts "$state/etc/preferences.d";
Dir::State::lists "$state/lists";
Dir::State::status "$state/status";
Dir::Cache "$state/cache";
Dir::Log "$state/log";
CONF
  apt-get -c "$state/apt.conf" -qq update
  apt-get -c "$state/apt.conf" -qq -y -o Debug::NoLocking=1 --download-only install "$@" >/dev/null
  mkdir -p "$to"
  local package
  for package in "$state"/cache/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" |
      tar -C "$to" -xf - --exclude=./usr/share/doc --exclude=./usr/share/man --exclude=./usr/share/locale \
        --keep-directory-symlink
  done
  # Absolute links would lead out of the sysroot.
  find "$to" -type l -lname '/*' -printf '%p\t%l\n' | while IFS=$'\t' read -r link target; do
    ln -sfn "$(realpath -m --relative-to="$(dirname "$link")" "$to$target")" "$link"
  done
}

fetch arm64 "$sysroot" "${packages[@]}"
fetch "$(dpkg --print-architecture)" "$qemu" "${emulator[@]}"
echo "$sysroot: $(du -sh "$sysroot" | cut -f1); $qemu: $(du -sh "$qemu" | cut -f1)"
