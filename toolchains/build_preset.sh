# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
# Sourced by scripts of this project that need something built, which stand in the project's folder.

# Makes the sysroot of a preset for boards, if it has one and it is not there.
sysroot_of() { # preset
  case $1 in
    arm64 | arm64-count) [ -d build/sysroots/debian12-arm64 ] || toolchains/sysroot.sh arm64 ;;
    armhf) [ -d build/sysroots/debian12-armhf ] || toolchains/sysroot.sh armhf ;;
    arm64-debian13) [ -d build/sysroots/debian13-arm64 ] || toolchains/sysroot.sh arm64 --debian 13 ;;
  esac
}

# Installs, configures and builds what is missing; what the tools say is in build/PRESET.log, and shown when one fails.
build_preset() { # preset, targets...
  local preset=$1 log=build/$1.log
  shift
  mkdir -p build
  tests/install_packages.sh || return
  case $preset in arm*) tests/install_packages.sh toolchains/packages.txt && sysroot_of "$preset" || return ;; esac
  {
    { [ -f "build/$preset/build.ninja" ] || cmake --preset "$preset"; } && cmake --build "build/$preset" --target "$@"
  } >"$log" 2>&1 </dev/null && return
  echo "building $* of the preset $preset failed; the end of $log:" >&2
  tail -n 40 "$log" >&2
  return 1
}
