#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Are sources as .clang-format has them, do scripts pass shellcheck, are words spelt as in a dictionary? Names each place.
# usage: style.sh [format|scripts|spelling]...   (default: all; to format: git ls-files '*.cpp' '*.hpp' | xargs clang-format -i)
set -uo pipefail

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." || exit 2
[ $# -gt 0 ] || set -- format scripts spelling
listed() { git -c safe.directory='*' ls-files -z -- "$@"; }
scripts() { listed | xargs -0r grep -lZE --no-messages '^#!/(usr/)?bin/(env |busybox )?(ba)?sh$|^# shellcheck shell=' -- | grep -zvE '[.](md|py)$'; }
failed=0
for what in "$@"; do
  case $what in
    format) listed '*.cpp' '*.hpp' '*.c' | xargs -0r -P 2 -n 100 clang-format --dry-run --Werror || failed=1 ;;
    scripts) scripts | xargs -0r shellcheck --external-sources --severity=warning || failed=1 ;;
    spelling) listed ':!*.png' ':!*.svg' ':!LICENSE' ':!tests/data/fuzz' | xargs -0r codespell || failed=1 ;;
    *) sed -n 's/^# usage: /usage: /p' "${BASH_SOURCE[0]}" >&2; exit 2 ;;
  esac
done
exit "$failed"
