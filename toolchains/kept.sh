# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
# Sourced by scripts that make something large out of Debian's packages: it is kept between clones, by the content of the
# files that say how it is made, for 30 days, since the archive moves on. SRD_KEPT names another folder.
kept_folder=${SRD_KEPT:-${XDG_CACHE_HOME:-${HOME:-$PWD/build}/.cache}/flume-srd}

kept_path() { # name, files that say how it is made -> where it is, or is to be put
  local name=$1 old
  shift
  mkdir -p "$kept_folder"
  for old in "$kept_folder/$name"-*; do
    # A file or folder is touched when it is whole, never later.
    [ ! -e "$old" ] || [ -z "$(find "$old" -maxdepth 0 -mtime +30)" ] || rm -rf -- "$old"
  done
  echo "$kept_folder/$name-$(cat -- "$@" | sha256sum | cut -c 1-16)"
}

keep() { # file or folder that is whole now, where it is kept
  touch -- "$1"
  # Of two that made it at once the first one's stays.
  mv -nT -- "$1" "$2" && rm -rf -- "$1"
}

from_kept() { # kept folder, copy: of hard links where the file system allows, for reading alone
  rm -rf -- "$2" "$2.part"
  mkdir -p -- "$(dirname -- "$2")"
  cp -al -- "$1" "$2.part" 2>/dev/null || { rm -rf -- "$2.part"; cp -a -- "$1" "$2.part"; }
  mv -T -- "$2.part" "$2"
}
