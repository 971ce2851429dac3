#!/usr/bin/env bash
# Installs what is missing, builds, runs every test that needs no hardware: built by GCC, then by Clang with
# address and undefined-behaviour sanitizers (the slow tests not again), then the node's threads under the thread sanitizer.
# --quick: GCC only. --boards: then also for boards, all emulated: unit tests for arm64 and armhf, their results against this
# machine's bit for bit, srd-node on a board with cameras and GPIO lines, packages installed, upgraded and removed, and what
# a computer with nothing but Debian 12 on it has after the lists of packages are installed.
# Last line: "N passed, N failed, N skipped". Exit code 0 only when nothing failed.
set -euo pipefail

usage() { echo "usage: tests/run.sh [--quick | --boards]   (builds in build/, see CMakePresets.json)"; }

stages=(host asan-ubsan tsan)
boards=false
for argument in "$@"; do
  case $argument in
    --quick) stages=(host) ;;
    --boards) boards=true ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
done

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
tests/install_packages.sh
results=()

# A stage is judged by its JUnit file. One that a previous run left behind must not speak for this one.
run_stage() { # preset
  local report=build/$1/junit.xml started=$SECONDS verdict=passed
  results+=("$1=$report")
  rm -f -- "$report"
  echo "== $1"
  cmake --workflow --preset "$1" </dev/null || verdict=FAILED
  echo "== $1: $verdict after $((SECONDS - started)) s"
}

# A job is judged by its exit code.
run_job() { # name, command...
  local name=$1 code=0 started=$SECONDS
  shift
  echo "== $name"
  "$@" </dev/null || code=$?
  results+=("$name=exit:$code")
  echo "== $name: $([ "$code" -eq 0 ] && echo passed || echo "FAILED with code $code") after $((SECONDS - started)) s"
}

for stage in "${stages[@]}"; do run_stage "$stage"; done
if $boards; then
  tests/install_packages.sh toolchains/packages.txt
  echo "Emulated boards leave out the tests of the pattern metric, which srd-node has not, and those of thousands of noise draws."
  for board in arm64 armhf; do
    [ -d "build/sysroots/debian12-$board" ] || run_job "sysroot $board" toolchains/sysroot.sh "$board"
    run_stage "$board"
    run_job "$board bit for bit" tests/bench/compare_architectures.sh "$board" 4
  done
  run_job "virtual board" tests/virtual_board/run.sh --debian13
  if [ "$(id -u)" -eq 0 ]; then
    run_job "fresh machine" tests/fresh_machine/run.sh
    run_job "packages" tests/packaging/run.sh amd64 arm64 armhf
  else
    echo "Not run, they need root: tests/fresh_machine/run.sh, tests/packaging/run.sh"
  fi
fi

python3 tests/summarise_runs.py "${results[@]}"
