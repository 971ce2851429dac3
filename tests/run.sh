#!/usr/bin/env bash
# Installs what is missing, builds, runs every test that needs no hardware: built by GCC, then by Clang with
# address and undefined-behaviour sanitizers (the slow tests not again), then the node's threads under the thread sanitizer.
# --quick: GCC only. Last line: "N passed, N failed, N skipped". Exit code 0 only when nothing failed.
set -euo pipefail

usage() { echo "usage: tests/run.sh [--quick]   (builds in build/, see CMakePresets.json)"; }

stages=(host asan-ubsan tsan)
for argument in "$@"; do
  case $argument in
    --quick) stages=(host) ;;
    -h | --help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
  esac
done

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.."
tests/install_packages.sh

# A stage is judged by its JUnit file. One that a previous run left behind must not speak for this one.
reports=()
for stage in "${stages[@]}"; do
  report=build/$stage/junit.xml
  reports+=("$stage=$report")
  rm -f -- "$report"
  echo "== $stage"
  started=$SECONDS
  if cmake --workflow --preset "$stage" </dev/null; then verdict=passed; else verdict=FAILED; fi
  echo "== $stage: $verdict after $((SECONDS - started)) s"
done

python3 tests/summarise_runs.py "${reports[@]}"
