#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# make_admindir.sh SYSROOT FOLDER: a dpkg database for dpkg-shlibdeps out of the sysroot's own.
# dpkg-shlibdeps asks for the owner of the path where it found a library, which is below the sysroot: so are the paths here.
set -eu
sysroot=${1:?usage: make_admindir.sh SYSROOT FOLDER}
to=${2:?usage: make_admindir.sh SYSROOT FOLDER}
from=$sysroot/var/lib/dpkg
if [ ! -s "$from/status" ]; then
  echo "make_admindir: $sysroot has no package database: make it anew with toolchains/sysroot.sh" >&2
  exit 1
fi
[ ! "$to/status" -nt "$from/status" ] || exit 0
rm -rf "$to"
mkdir -p "$to/info" "$to/updates" "$to/triggers"
for list in "$from"/info/*.list; do
  sed -e "s|^|$sysroot|" "$list" >"$to/info/${list##*/}"
done
find "$from/info" \( -name '*.symbols' -o -name '*.shlibs' \) -exec cp -t "$to/info" {} +
echo 1 >"$to/info/format"
cp "$from/status" "$to/status"
