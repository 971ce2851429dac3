#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, runs every test that needs no hardware: built by GCC, with board/demo.sh and clang-tidy; then by
# Clang with address and undefined-behaviour sanitizers (the slow tests not again); fuzzers of what comes from outside, 20 s each;
# then the node's threads under the thread sanitizer.
# --quick: GCC only, without the slow tests. --boards: then also for boards, all emulated: unit tests for arm64, their
# results against this machine's bit for bit, srd-node on a board with cameras and GPIO lines, packages installed, upgraded
# and removed, and what a computer with nothing but Debian 12 on it has after the lists of packages are installed.
# --all: then also armhf (unit tests, bit for bit, its package) and the drivers built for Debian 13.
# Ends with the seconds of each stage, and "N passed, N failed, N skipped". Exit code 0 only when nothing failed.
set -euo pipefail

usage() { echo "usage: tests/run.sh [--quick | --boards | --all]   (builds in build/, see CMakePresets.json)"; }

stages=(host asan-ubsan tsan)
boards=false
all=false
for argument in "$@"; do
  case $argument in
    --quick) stages=(quick) ;;
    --boards) boards=true ;;
    --all) boards=true all=true ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
done

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
. toolchains/build_preset.sh
tests/install_packages.sh
results=()
seconds=()

# What boards need from Debian's archive is fetched and unpacked while the first stages compile.
prepare_boards() {
  for board in arm64 armhf arm64-debian13; do sysroot_of "$board" || return; done
  [ -d build/virtual-board ] || toolchains/virtual_board/build.sh || return
  [ "$(id -u)" -ne 0 ] || { tests/fresh_machine/run.sh --make && tests/packaging/run.sh --make amd64 arm64; }
}
prepared=
if $boards; then
  tests/install_packages.sh toolchains/packages.txt
  mkdir -p build
  prepare_boards >build/prepare.log 2>&1 </dev/null &
  prepared=$!
fi

# A stage is judged by its JUnit file. One that a previous run left behind must not speak for this one.
run_stage() { # workflow
  local report=build/$1/junit.xml started=$SECONDS verdict=passed
  results+=("$1=$report")
  mkdir -p "build/$1"
  rm -f -- "$report"
  echo "== $1"
  cmake --workflow --preset "$1" </dev/null || verdict=FAILED
  echo "== $1: $verdict after $((SECONDS - started)) s"
  seconds+=("$(printf '%6d s  %s' $((SECONDS - started)) "$1")")
}

# A job is judged by its exit code.
run_job() { # name, command...
  local name=$1 code=0 started=$SECONDS
  shift
  echo "== $name"
  "$@" </dev/null || code=$?
  results+=("$name=exit:$code")
  seconds+=("$(printf '%6d s  %s' $((SECONDS - started)) "$name")")
  echo "== $name: $([ "$code" -eq 0 ] && echo passed || echo "FAILED with code $code") after $((SECONDS - started)) s"
}

wait_for() { # process, its log
  wait "$1" || { tail -n 30 "$2"; return 1; }
}

# The user's first command, anew each time, and what it measured against the truth.
demo_measures() {
  rm -rf -- build/demo
  board/demo.sh --out build/demo && build/host/host/srd compare build/demo/coefficients.csv build/demo/truth.csv --max-rms 0.02
}

for stage in "${stages[@]}"; do
  run_stage "$stage"
  [ "$stage" != "${stages[0]}" ] || run_job "demo" demo_measures
  [ "$stage" != host ] || run_job "clang-tidy" tests/structure/tidy.py
  [ "$stage" != asan-ubsan ] || run_job "fuzzers" tests/fuzz/run.sh
done
if $boards; then
  run_job "what boards need" wait_for "$prepared" build/prepare.log
  echo "Emulated boards leave out the tests of the pattern metric, which srd-node has not, and those of thousands of noise draws."
  architectures=(arm64)
  debian13=()
  if $all; then architectures+=(armhf) debian13=(--debian13); fi
  for board in "${architectures[@]}"; do
    run_stage "$board"
    run_job "$board bit for bit" tests/bench/compare_architectures.sh "$board" 4
  done
  run_job "virtual board" tests/virtual_board/run.sh "${debian13[@]}"
  if [ "$(id -u)" -eq 0 ]; then
    run_job "fresh machine" tests/fresh_machine/run.sh
    run_job "packages" tests/packaging/run.sh amd64 "${architectures[@]}"
  else
    echo "Not run, they need root: tests/fresh_machine/run.sh, tests/packaging/run.sh"
  fi
fi

printf '%s\n' "${seconds[@]}"
python3 tests/summarise_runs.py "${results[@]}"
