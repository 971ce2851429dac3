# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
# Sourced by scripts that need a Debian system to try something in, after debian_packages.sh and kept.sh: systems of this
# machine's architecture, and of others, run by qemu.

# Programs of another architecture run through qemu, which the kernel must know of. F: found once, outside the root.
registered=
forget_interpreter() {
  [ -z "$registered" ] || echo -1 >"/proc/sys/fs/binfmt_misc/$registered"
}
trap forget_interpreter EXIT
know_interpreter() { # architecture
  local name qemu magic mask=
  case $1 in
    arm64) name=aarch64 qemu=qemu-aarch64-static; magic='\x7fELF\x02\x01\x01\x00\x00\x00\x00\x00\x00\x00\x00\x00\x02\x00\xb7\x00' ;;
    armhf) name=arm qemu=qemu-arm-static; magic='\x7fELF\x01\x01\x01\x00\x00\x00\x00\x00\x00\x00\x00\x00\x02\x00\x28\x00' ;;
    *) return 0 ;;
  esac
  mask='\xff\xff\xff\xff\xff\xff\xff\x00\xff\xff\xff\xff\xff\xff\xff\xff\xfe\xff\xff\xff'
  [ -e /proc/sys/fs/binfmt_misc/register ] || mount -t binfmt_misc binfmt_misc /proc/sys/fs/binfmt_misc 2>/dev/null
  local known
  for known in /proc/sys/fs/binfmt_misc/*; do
    ! grep -qs "interpreter.*qemu-$name" "$known" || return 0
  done
  qemu=$(command -v "$qemu") || return 1
  forget_interpreter
  registered=srd-$name-$$
  { echo ":$registered:M::$magic:$mask:$qemu:F" >/proc/sys/fs/binfmt_misc/register; } 2>/dev/null || {
    registered=
    return 1
  }
  # mmdebstrap asks the same question of the same program before it makes a system.
  arch-test "$1" >/dev/null
}

# A minimal system as a tar file, made once and kept whole; packages that are fetched for it later are kept beside it.
make_root() { # architecture, release; sets root_tar and root_archives
  local archive codename
  root_tar=$(kept_path "root-debian$2-$1" toolchains/emulated_root.sh).tar || return 1
  # shellcheck disable=SC2034,SC2154  # read by who called; set by kept.sh
  root_archives=$kept_folder/archives-debian$2-$1
  [ ! -s "$root_tar" ] || return 0
  codename=$(debian_codename "$2") || return 1
  archive=$(debian_source) || return 1
  mmdebstrap --quiet --variant=minbase --architectures="$1" --mode=root --skip=cleanup/apt \
    --components=main "$codename" "$root_tar.$$.tar" "$archive" && keep "$root_tar.$$.tar" "$root_tar"
}

# Runs a command as root of the system in a folder. Packages that it fetches are kept in another; mounts end with it.
in_emulated_root() { # folder, archives, command...
  mkdir -p "$2/partial"
  cp /etc/resolv.conf "$1/etc/resolv.conf"
  # shellcheck disable=SC2016  # expanded inside
  unshare --mount --pid --fork --kill-child sh -c '
    mount -t proc proc "$1/proc" && mount -t sysfs -o ro sysfs "$1/sys" && mount -t tmpfs tmpfs "$1/tmp" &&
    mount -t tmpfs tmpfs "$1/run" && mount --rbind /dev "$1/dev" && mount --bind "$2" "$1/var/cache/apt/archives" &&
    root=$1 && shift 2 && exec chroot "$root" "$@"' sh "$@"
}
