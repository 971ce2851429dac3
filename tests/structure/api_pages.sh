#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Pages of the headers of dsp and of the cameras, by Doxygen: build/api/html/index.html. A warning is an error.
set -euo pipefail

cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
command -v doxygen >/dev/null || { echo "SKIP: no doxygen (tests/install_packages.sh installs it)"; exit 77; }
rm -rf build/api
mkdir -p build/api
mapfile -t headers < <(git -c safe.directory='*' ls-files -- 'dsp/*.hpp' 'drivers/camera/*.hpp')
python3 -B tests/structure/doxygen_comments.py build/api/headers "${headers[@]}"
doxygen dsp/Doxyfile
# What people wrote is on the pages: a class, a function of it, a member with its unit behind it.
shown() { grep -qF -- "$2" "build/api/html/$1" || { echo "api_pages: $1 does not say: $2" >&2; exit 1; }; }
shown classsrd_1_1Camera.html "give_back from any."
shown classsrd_1_1Camera.html "Opens the device, reserves all buffers."
shown structsrd_1_1GrayView.html "from one row to the next, &gt;= width"
shown surface__tracker_8hpp.html "does not allocate, throw, or read a clock"
echo "the pages begin at build/api/html/index.html"
