# shellcheck shell=sh
# SPDX-License-Identifier: Apache-2.0
# Sourced by scripts that check one thing after the other: a line each, and failed=1 when one does not hold. What a command
# says is shown when it fails, or always with check_shows=always.
failed=0
check_shows=${check_shows:-failures}
check_said=$(mktemp)

check() { # name, command...
  check_name=$1
  shift
  if "$@" >"$check_said" 2>&1; then
    echo "ok    $check_name"
    [ "$check_shows" != always ] || sed 's/^/      /' "$check_said"
  else
    echo "FAIL  $check_name: $*"
    sed 's/^/      /' "$check_said"
    # shellcheck disable=SC2034  # read by the script that sources this
    failed=1
  fi
}
