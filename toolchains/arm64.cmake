# SPDX-License-Identifier: Apache-2.0
# 64-bit ARM boards: Raspberry Pi 3 and later, any armv8-a.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(SRD_TRIPLET aarch64-linux-gnu)
set(SRD_DEBIAN_ARCHITECTURE arm64)
set(SRD_EMULATOR qemu-aarch64-static)
include(${CMAKE_CURRENT_LIST_DIR}/debian.cmake)
