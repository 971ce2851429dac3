#!/usr/bin/env bash
# Installs the packages of builds into emulated Debian systems, upgrades, removes and purges them there: in_root.sh.
# Takes build/<preset>/packages/*.deb, made by cpack first when the build is newer. Needs root, and the archive for new systems
# (kept in build/roots). Ends with a table; exit code 0 only when every architecture passed.
set -uo pipefail

usage() {
  cat <<'USAGE'
usage: tests/packaging/run.sh [--debian 12|13] [amd64|arm64|armhf]...   (default: every architecture that is built)
  builds: amd64 in build/host, arm64 in build/arm64, armhf in build/armhf; with --debian 13 in build/<those>-debian13
USAGE
}

release=12
architectures=()
while [ $# -gt 0 ]; do
  case $1 in
    amd64 | arm64 | armhf) architectures+=("$1") ;;
    --debian) release=${2:-}; shift ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
  shift
done

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." || exit 2
. toolchains/debian_packages.sh
. tests/packaging/emulated_root.sh
codename=$(debian_codename "$release") || exit 2
roots=$PWD/build/roots

folder_of() { # architecture -> its build folder
  local folder=build/$1
  [ "$1" != amd64 ] || folder=build/host
  [ "$release" = 12 ] || folder+=-debian$release
  echo "$folder"
}
if [ ${#architectures[@]} -eq 0 ]; then
  for architecture in amd64 arm64 armhf; do
    [ ! -e "$(folder_of $architecture)/CPackConfig.cmake" ] || architectures+=("$architecture")
  done
fi
if [ ${#architectures[@]} -eq 0 ]; then
  echo "packaging: nothing is built: cmake --preset host && cmake --build --preset host" >&2
  exit 2
fi
if [ "$(id -u)" -ne 0 ]; then
  echo "packaging: making a Debian system needs root." >&2
  exit 2
fi
tests/install_packages.sh tests/packaging/packages.txt || exit 2

# The same package with a later version and a profile that differs: what a release would be.
make_next() { # from, to, suffix
  local work
  work=$(mktemp -d)
  dpkg-deb -R "$1" "$work/tree"
  sed -i "s/^Version: .*/&+$3/" "$work/tree/DEBIAN/control"
  echo "# profile of the $3" >>"$work/tree/usr/share/flume-srd/profiles/generic-v4l2/node.toml"
  (cd "$work/tree" && find usr -type f -print0 | xargs -0 md5sum >DEBIAN/md5sums)
  dpkg-deb -Zgzip --root-owner-group -b "$work/tree" "$2" >/dev/null
  rm -rf "$work"
}

fail() { echo "FAIL  $*"; return 1; }

try() { # architecture
  local build package tree packages profile board
  build=$(folder_of "$1")
  [ -e "$build/CPackConfig.cmake" ] || { fail "$build is not built"; return 1; }
  (cd "$build" && rm -f packages/*.deb && cpack -G DEB -B packages >packages.log 2>&1) || { cat "$build/packages.log"; fail cpack; return 1; }
  package=$(ls "$build"/packages/flume-srd-node_*_"$1".deb) || { fail "no package for $1 in $build/packages"; return 1; }
  make_root "$1" "$codename" "$roots/debian$release-$1.tar" || { fail "no Debian $release system for $1"; return 1; }

  tree=$roots/work-$1-$$
  packages=$tree/packages
  rm -rf "$tree"
  mkdir -p "$tree"
  tar -C "$tree" -xf "$roots/debian$release-$1.tar" || return 1
  mkdir -p "$packages/geometry"
  cp "$package" "$packages/install.deb"
  make_next "$package" "$packages/upgrade.deb" upgrade
  make_next "$packages/upgrade.deb" "$packages/next.deb" next
  # The host's program is for the lab's computer, which is a PC.
  [ "$1" != amd64 ] || cp "$build"/packages/flume-srd_*_"$1".deb "$packages/host.deb" || return 1
  for profile in board/*/node.toml; do
    board=$(basename "$(dirname "$profile")")
    mkdir -p "$packages/geometry/$board"
    python3 tests/packaging/write_geometry.py "$profile" "$packages/geometry/$board" || return 1
  done
  cp tests/packaging/in_root.sh tests/check.sh "$packages/"
  in_emulated_root "$tree" "$roots/archives-$release-$1" /bin/sh /packages/in_root.sh
  local code=$?
  rm -rf --one-file-system "$tree"
  return $code
}

table=()
code=0
for architecture in "${architectures[@]}"; do
  echo "== $architecture, Debian $release"
  started=$SECONDS
  log=$roots/$architecture-$release.log
  mkdir -p "$roots"
  if know_interpreter "$architecture"; then
    try "$architecture" 2>&1 | tee "$log"
    [ "${PIPESTATUS[0]}" -eq 0 ] || code=1
  else
    echo "FAIL  the kernel does not run programs for $architecture:" \
      "install qemu-user-static; in a container, binfmt_misc is its host's to set up" | tee "$log"
    code=1
  fi
  passed=$(grep -c '^ok ' "$log")
  failures=$(grep -c '^FAIL ' "$log")
  if [ "$failures" -gt 0 ] || [ "$passed" -eq 0 ]; then code=1; fi
  table+=("$(printf '%-12s  %-10s  %6d  %6d  %5d s' "$architecture" "Debian $release" "$passed" "$failures" $((SECONDS - started)))")
done
echo
echo "architecture  system      passed  failed     time"
printf '%s\n' "${table[@]}"
exit $code
