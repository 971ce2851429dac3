# SPDX-License-Identifier: Apache-2.0
# Read by cpack itself, before it makes a package: whose libraries dpkg-shlibdeps asks for.
if(CPACK_SRD_SYSROOT)
  execute_process(COMMAND ${CPACK_SRD_MAKE_ADMINDIR} ${CPACK_SRD_SYSROOT} ${CPACK_SRD_ADMINDIR}
    COMMAND_ERROR_IS_FATAL ANY)
  set(ENV{DPKG_ADMINDIR} ${CPACK_SRD_ADMINDIR})
  set(ENV{DEB_HOST_ARCH} ${CPACK_DEBIAN_PACKAGE_ARCHITECTURE})
endif()
