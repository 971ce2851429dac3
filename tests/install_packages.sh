#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing of tests/packages.txt, or of the list that is given. With nothing missing: no network, no root.
set -euo pipefail

case ${1:-} in
  -h | --help) echo "usage: tests/install_packages.sh [LIST]   (default: tests/packages.txt)"; exit 0 ;;
esac
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
list=${1:-$here/packages.txt}
[ -r "$list" ] || { echo "install_packages: $list: no file with names of packages that can be read" >&2; exit 2; }
mapfile -t wanted < <(sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' "$list")

if ! command -v dpkg-query >/dev/null; then
  echo "install_packages: this system has no Debian packages (no dpkg-query)." >&2
  echo "  needed, by their Debian 12 names: ${wanted[*]}" >&2
  echo "  try: install their equivalents, then configure with: cmake --preset host" >&2
  exit 1
fi

list_missing() {
  local package
  for package in "${wanted[@]}"; do
    # shellcheck disable=SC2016  # dpkg-query's own field syntax
    if [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
      echo "$package"
    fi
  done
}

mapfile -t missing < <(list_missing)
[ "${#missing[@]}" -gt 0 ] || exit 0
echo "install_packages: missing: ${missing[*]}"

give_up() {
  mapfile -t missing < <(list_missing)
  echo "install_packages: $1" >&2
  echo "  not installed: ${missing[*]}" >&2
  echo "  try, as root: apt-get update && apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 1
}

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || give_up "not root, and there is no sudo."
  sudo -n true 2>/dev/null || give_up "not root, and sudo asks for a password."
  as_root=(sudo -n)
fi

apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 \
    -o Acquire::Retries=2 "$@" </dev/null
}

# Lists may be stale without being useless: what counts is whether the packages arrive.
apt update || echo "install_packages: the package lists could not be refreshed." >&2
apt install -y --no-install-recommends "${missing[@]}" || give_up "apt-get could not install (see its messages above)."
mapfile -t missing < <(list_missing)
[ "${#missing[@]}" -eq 0 ] || give_up "apt-get ended well, but packages are still missing."
