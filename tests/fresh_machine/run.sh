#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A computer that has nothing but Debian 12: makes a minimal system, installs every packages.txt of the project in it, and finds
# there every program that the project's scripts call; then configures every preset. The system is kept by the content of the
# lists and is read-only while it is used. Needs root. Ends with 0 when every check held.
# --demo: then board/demo.sh in it, from nothing, as a user's first command on a new computer. --make: the system, no more.
set -uo pipefail

usage() { echo "usage: tests/fresh_machine/run.sh [--demo | --make]"; }
demo=false
make=false
for argument in "$@"; do
  case $argument in
    --demo) demo=true ;;
    --make) make=true ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
done

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." || exit 2
[ "$(id -u)" -eq 0 ] || { echo "fresh_machine: making a Debian system needs root." >&2; exit 2; }
. toolchains/debian_packages.sh
. toolchains/kept.sh
. toolchains/build_preset.sh
. toolchains/emulated_root.sh
. tests/check.sh
tests/install_packages.sh && tests/install_packages.sh toolchains/packages.txt || exit 2
mapfile -t lists < <(git -c safe.directory='*' ls-files -- packages.txt '*/packages.txt')
[ "${#lists[@]}" -gt 0 ] || { echo "fresh_machine: no packages.txt is under git's control here." >&2; exit 2; }

architecture=$(dpkg --print-architecture)
work=$PWD/build/fresh-machine
mkdir -p build
make_root "$architecture" 12 || { echo "fresh_machine: no minimal Debian 12 could be made." >&2; exit 1; }
system=$(kept_path fresh-machine toolchains/emulated_root.sh tests/install_packages.sh "${lists[@]}")

# The lists are installed by the same script that a user's first command calls, one after the other.
make_system() {
  local list
  mkdir -p "$part/flume/lists" && tar -C "$part" -xf "$root_tar" || return
  cp tests/install_packages.sh "$part/flume/lists/"
  for list in "${lists[@]}"; do
    cp "$list" "$part/flume/lists/list" || return
    in_emulated_root "$part" "$root_archives" /flume/lists/install_packages.sh /flume/lists/list || {
      echo "$list could not be installed on a fresh system" >&2
      return 1
    }
  done
  rm -r "$part/flume/lists" && chmod 755 "$part" && keep "$part" "$system"
}
if [ ! -d "$system" ]; then
  echo "-- making the system"
  part=$(mktemp -d "$kept_folder/part.XXXXXX")
  trap 'rm -rf --one-file-system -- "$part"' EXIT
  make_system >"$work.log" 2>&1 </dev/null || { tail -n 30 "$work.log"; exit 1; }
fi

! $make || exit 0

# A clone of what is here, as git would hand it to a stranger, with the sysroots beside it.
rm -rf -- "$work"
mkdir -p "$work/clone/build/sysroots"
git -c safe.directory='*' ls-files -z | tar --null -T - -cf - | tar -C "$work/clone" -xf -
git -C "$work/clone" init -q && git -C "$work/clone" add -A
mapfile -t presets < <(cmake --list-presets=configure | sed -n 's/^ *"\([^"]*\)".*/\1/p')
for preset in "${presets[@]}"; do sysroot_of "$preset" >/dev/null || exit 1; done

# Nothing of this machine is seen but its name server; the system itself cannot be written.
in_system() { # command...
  # shellcheck disable=SC2016  # expanded inside
  unshare --mount --pid --fork --kill-child sh -c '
    mount --bind "$1" "$1" && mount -o remount,bind,ro "$1" && mount -t proc proc "$1/proc" && mount -t sysfs -o ro sysfs "$1/sys" &&
    mount -t tmpfs tmpfs "$1/tmp" && mount -t tmpfs tmpfs "$1/run" && mount --rbind /dev "$1/dev" &&
    mount --bind "$2" "$1/flume" && mount --rbind "$3" "$1/flume/build/sysroots" && system=$1 && shift 3 &&
    exec chroot "$system" env -i HOME=/tmp PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
      sh -c "cd /flume && exec \"\$@\"" sh "$@"' sh "$system" "$work/clone" "$PWD/build/sysroots" "$@"
}
all_lists_are_installed() {
  local list
  for list in "${lists[@]}"; do in_system tests/install_packages.sh "$list" || return; done
}
configure() { # preset; its log stays in the clone
  in_system cmake --preset "$1" >"$work/clone/build/$1.log" 2>&1 </dev/null
}
configured() { # preset
  [ -f "$work/clone/build/$1/build.ninja" ] && [ ! -e "$work/clone/build/$1.failed" ] || { tail -n 30 "$work/clone/build/$1.log"; return 1; }
}

started=$SECONDS
check "every list is installed there: ${lists[*]}" all_lists_are_installed
check "programs are found wherever a script calls them" in_system python3 -B tests/fresh_machine/called_programs_test.py
check_shows=always
check "every program that the scripts call is there" in_system python3 -B tests/fresh_machine/called_programs.py --missing
check_shows=failures
# Two at once, one for each of two cores: most of a configuration is waiting for one compiler after the other.
running=()
for preset in "${presets[@]}"; do
  (configure "$preset" || : >"$work/clone/build/$preset.failed") &
  running+=($!)
  [ ${#running[@]} -lt 2 ] || { wait "${running[0]}"; running=("${running[@]:1}"); }
done
wait
for preset in "${presets[@]}"; do check "preset $preset is configured there" configured "$preset"; done
if $demo; then
  check_shows=always
  check "board/demo.sh measures there" in_system board/demo.sh --out /flume/build/demo
fi
rm -f -- "$check_said"
echo "== fresh machine: $([ "$failed" -eq 0 ] && echo passed || echo FAILED) after $((SECONDS - started)) s in the system"
exit "$failed"
