# SPDX-License-Identifier: Apache-2.0
# 32-bit ARM boards with NEON: Raspberry Pi 2 and later under a 32-bit system. Debian's armhf itself asks for less (no NEON),
# but the vector kernels are what makes camera rate possible there.
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(SRD_TRIPLET arm-linux-gnueabihf)
set(SRD_DEBIAN_ARCHITECTURE armhf)
set(SRD_EMULATOR qemu-arm-static)
# 32-bit NEON divides by approximation and flushes small numbers: Eigen is kept from it, so that the surface is that of all
# other boards. The front end's kernels are integer and use it.
# Highway names half floats, which GCC has only when told their format.
set(CMAKE_C_FLAGS_INIT "-march=armv7-a+neon-vfpv4 -mfloat-abi=hard -mfp16-format=ieee -DEIGEN_DONT_VECTORIZE")
set(CMAKE_CXX_FLAGS_INIT "${CMAKE_C_FLAGS_INIT}")
include(${CMAKE_CURRENT_LIST_DIR}/debian.cmake)
