#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the packages of builds into emulated Debian systems, upgrades, removes and purges them there: in_root.sh.
# Builds what it packs. Needs root, and Debian's archive for new systems, which are kept between clones (toolchains/kept.sh).
# Ends with a table; exit code 0 only when every architecture passed.
set -uo pipefail

usage() {
  cat <<'USAGE'
usage: tests/packaging/run.sh [--debian 12|13] [--make] [amd64|arm64|armhf]...   (default: all three)
  --make: the emulated systems, no more
  builds: amd64 in build/host, arm64 in build/arm64, armhf in build/armhf; with --debian 13 in build/<those>-debian13
USAGE
}

release=12
make=false
architectures=()
while [ $# -gt 0 ]; do
  case $1 in
    amd64 | arm64 | armhf) architectures+=("$1") ;;
    --make) make=true ;;
    --debian) release=${2:-}; shift ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
  shift
done

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." || exit 2
. toolchains/debian_packages.sh
. toolchains/kept.sh
. toolchains/build_preset.sh
. toolchains/emulated_root.sh
debian_codename "$release" >/dev/null || exit 2
roots=$PWD/build/roots

preset_of() { # architecture -> the preset that builds for it
  local preset=$1
  [ "$1" != amd64 ] || preset=host
  [ "$release" = 12 ] || preset+=-debian$release
  echo "$preset"
}
[ ${#architectures[@]} -gt 0 ] || architectures=(amd64 arm64 armhf)
if [ "$(id -u)" -ne 0 ]; then
  echo "packaging: making a Debian system needs root." >&2
  exit 2
fi
tests/install_packages.sh toolchains/packages.txt || exit 2

if $make; then
  for architecture in "${architectures[@]}"; do
    know_interpreter "$architecture" && make_root "$architecture" "$release" || exit 1
  done
  exit 0
fi

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
  local preset build package tree packages profile board programs=(srd-node)
  preset=$(preset_of "$1")
  build=build/$preset
  if [ ! -e "$build/CPackConfig.cmake" ] && ! cmake --list-presets=build | grep -q "\"$preset\""; then
    fail "no preset builds for $1 on Debian $release: configure $build by hand (board/README.md)"
    return 1
  fi
  # The host's program is for the lab's computer, which is a PC.
  [ "$1" != amd64 ] || programs+=(srd)
  build_preset "$preset" "${programs[@]}" || { fail "$build could not be built"; return 1; }
  (cd "$build" && rm -f packages/*.deb && cpack -G DEB -B packages >packages.log 2>&1) || { cat "$build/packages.log"; fail cpack; return 1; }
  package=$(ls "$build"/packages/flume-srd-node_*_"$1".deb) || { fail "no package for $1 in $build/packages"; return 1; }
  make_root "$1" "$release" || { fail "no Debian $release system for $1"; return 1; }

  tree=$roots/work-$1-$$
  packages=$tree/packages
  rm -rf "$tree"
  mkdir -p "$tree"
  tar -C "$tree" -xf "$root_tar" || return 1
  mkdir -p "$packages/geometry"
  cp "$package" "$packages/install.deb"
  make_next "$package" "$packages/upgrade.deb" upgrade
  make_next "$packages/upgrade.deb" "$packages/next.deb" next
  [ "$1" != amd64 ] || cp "$build"/packages/flume-srd_*_"$1".deb "$packages/host.deb" || return 1
  for profile in board/*/node.toml; do
    board=$(basename "$(dirname "$profile")")
    mkdir -p "$packages/geometry/$board"
    python3 tests/packaging/write_geometry.py "$profile" "$packages/geometry/$board" || return 1
  done
  cp tests/packaging/in_root.sh tests/check.sh "$packages/"
  in_emulated_root "$tree" "$root_archives" /bin/sh /packages/in_root.sh
  local code=$?
  rm -rf --one-file-system "$tree"
  return $code
}

# The systems are emulated side by side: each is one process most of the time.
running=()
begun=$SECONDS
mkdir -p "$roots"
for architecture in "${architectures[@]}"; do
  {
    trap forget_interpreter EXIT
    if know_interpreter "$architecture"; then
      try "$architecture"
    else
      fail "the kernel does not run programs for $architecture:" \
        "install qemu-user-static; in a container, binfmt_misc is its host's to set up"
    fi
    code=$?
    echo "$((SECONDS - begun))" >"$roots/$architecture-$release.seconds"
    exit "$code"
  } >"$roots/$architecture-$release.log" 2>&1 </dev/null &
  running+=("$!")
done

table=()
code=0
for i in "${!architectures[@]}"; do
  architecture=${architectures[i]}
  log=$roots/$architecture-$release.log
  wait "${running[i]}" || code=1
  echo "== $architecture, Debian $release"
  cat "$log"
  passed=$(grep -c '^ok ' "$log")
  failures=$(grep -c '^FAIL ' "$log")
  if [ "$failures" -gt 0 ] || [ "$passed" -eq 0 ]; then code=1; fi
  table+=("$(printf '%-12s  %-10s  %6d  %6d  %5d s' "$architecture" "Debian $release" "$passed" "$failures" "$(cat "${log%.log}.seconds")")")
done
echo
echo "architecture  system      passed  failed     time"
printf '%s\n' "${table[@]}"
exit $code
