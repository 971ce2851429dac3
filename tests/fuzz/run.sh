#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the fuzzers and runs each for some seconds, two at a time, from the inputs in tests/data/fuzz and those that earlier runs
# found worth keeping (build/fuzz/corpus). An input that breaks a rule stays in build/fuzz/found; its name is printed.
# usage: tests/fuzz/run.sh [SECONDS]   (default 20; 3600 for a long look)
set -uo pipefail

case ${1:-20} in
  -h | --help) sed -n 's/^# usage: /usage: /p' "${BASH_SOURCE[0]}"; exit 0 ;;
  *[!0-9]* | 0*) sed -n 's/^# usage: /usage: /p' "${BASH_SOURCE[0]}" >&2; exit 2 ;;
esac
seconds=${1:-20}
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." || exit 2
. toolchains/build_preset.sh
names=()
for source in tests/fuzz/*_fuzzer.cpp; do
  name=${source##*/}
  names+=("${name%_fuzzer.cpp}")
done
build_preset fuzz "${names[@]/#/srd_fuzz_}" || exit 1

fuzz() { # name; its output goes to build/fuzz/NAME.log
  mkdir -p "build/fuzz/corpus/$1" "build/fuzz/found"
  "build/fuzz/tests/fuzz/srd_fuzz_$1" "-max_total_time=$seconds" -max_len=1200 -timeout=10 -rss_limit_mb=2048 \
    -print_final_stats=1 "-artifact_prefix=build/fuzz/found/$1-" "build/fuzz/corpus/$1" "tests/data/fuzz/$1" \
    >"build/fuzz/$1.log" 2>&1 </dev/null
}
failed=0
for ((i = 0; i < ${#names[@]}; i += 2)); do
  running=()
  for name in "${names[@]:i:2}"; do
    fuzz "$name" &
    running+=("$!:$name")
  done
  for each in "${running[@]}"; do
    name=${each#*:}
    if wait "${each%%:*}"; then
      echo "ok    $name: $(sed -n 's/^stat::number_of_executed_units: *//p' "build/fuzz/$name.log") inputs in $seconds s"
    else
      echo "FAIL  $name: the end of build/fuzz/$name.log:"
      tail -n 30 "build/fuzz/$name.log" | sed 's/^/      /'
      failed=1
    fi
  done
done
exit "$failed"
