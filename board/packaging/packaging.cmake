# SPDX-License-Identifier: Apache-2.0
# Debian packages of what this build has: flume-srd-node (srd-node, service, profiles) and flume-srd (srd).
#   cpack -G DEB --config build/<preset>/CPackConfig.cmake -B build/<preset>/packages
set(SRD_PACKAGE_REVISION 1 CACHE STRING "Debian revision of the packages")
set(SRD_PACKAGE_VERSION ${PROJECT_VERSION}-${SRD_PACKAGE_REVISION})
set(packaging ${CMAKE_CURRENT_LIST_DIR})
set(made ${PROJECT_BINARY_DIR}/packaging)
find_program(SRD_GZIP gzip REQUIRED)

# Policy wants manuals and changelogs compressed, the same bytes each time.
function(srd_install_compressed source name destination component)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
  configure_file(${source} ${made}/${component}/${name} @ONLY)
  execute_process(COMMAND ${SRD_GZIP} -9n -c ${made}/${component}/${name}
    OUTPUT_FILE ${made}/${component}/${name}.gz COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${made}/${component}/${name}.gz DESTINATION ${destination} COMPONENT ${component})
endfunction()

function(srd_install_documents package component)
  set(document share/doc/${package})
  srd_install_compressed(${packaging}/debian/changelog changelog.Debian ${document} ${component})
  install(FILES ${packaging}/debian/copyright DESTINATION ${document} COMPONENT ${component})
endfunction()

set(components "")
if(SRD_BUILD_NODE)
  list(APPEND components node)
  install(TARGETS srd-node RUNTIME DESTINATION bin COMPONENT node)
  install(PROGRAMS ${packaging}/configured.sh RENAME configured DESTINATION lib/flume-srd COMPONENT node)
  install(PROGRAMS ${packaging}/detect_board.sh RENAME detect-board DESTINATION lib/flume-srd COMPONENT node)
  install(FILES ${packaging}/flume-srd-node.service DESTINATION lib/systemd/system COMPONENT node)
  install(FILES ${packaging}/60-flume-srd.rules DESTINATION lib/udev/rules.d COMPONENT node)
  install(FILES ${packaging}/sysusers.conf RENAME flume-srd-node.conf DESTINATION lib/sysusers.d COMPONENT node)
  file(GLOB profiles CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/board/*/node.toml)
  foreach(profile IN LISTS profiles)
    get_filename_component(folder ${profile} DIRECTORY)
    install(DIRECTORY ${folder} DESTINATION share/flume-srd/profiles COMPONENT node
      FILES_MATCHING PATTERN node.toml PATTERN README.md PATTERN *.svg)
  endforeach()
  install(FILES ${PROJECT_SOURCE_DIR}/board/README.md RENAME board.md DESTINATION share/doc/flume-srd-node COMPONENT node)
  install(DIRECTORY DESTINATION /etc/flume-srd COMPONENT node)
  srd_install_compressed(${packaging}/man/srd-node.1 srd-node.1 share/man/man1 node)
  srd_install_documents(flume-srd-node node)
endif()
if(SRD_BUILD_HOST)
  list(APPEND components host)
  install(TARGETS srd RUNTIME DESTINATION bin COMPONENT host)
  srd_install_compressed(${packaging}/man/srd.1 srd.1 share/man/man1 host)
  srd_install_documents(flume-srd host)
endif()
if(NOT components)
  return()
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME flume-srd)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "Flume SRD maintainers <flume-srd@lists.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_SET_DESTDIR OFF)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${SRD_PACKAGE_REVISION})
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(CPACK_DEBIAN_NODE_PACKAGE_NAME flume-srd-node)
set(CPACK_DEBIAN_NODE_PACKAGE_SECTION science)
set(CPACK_DEBIAN_NODE_DESCRIPTION "water surface of a flume, measured beside the camera
srd-node runs on the board of one camera that looks down through the water
at a checkerboard. It strobes the light, finds and follows the corners, fits
a small model of the moving surface and sends its coefficients with their
deviations to a host that runs srd.
.
This package has the program, its service and a profile for each board.")
set(CPACK_DEBIAN_NODE_PACKAGE_DEPENDS
  "init-system-helpers (>= 1.52), systemd | systemd-standalone-sysusers | systemd-sysusers, ucf")
set(CPACK_DEBIAN_NODE_PACKAGE_RECOMMENDS "chrony | time-daemon, udev")
set(CPACK_DEBIAN_NODE_PACKAGE_SUGGESTS "flume-srd, gpiod, v4l-utils")
set(CPACK_DEBIAN_NODE_PACKAGE_CONTROL_EXTRA
  "${packaging}/debian/postinst;${packaging}/debian/prerm;${packaging}/debian/postrm")

set(CPACK_DEBIAN_HOST_PACKAGE_NAME flume-srd)
set(CPACK_DEBIAN_HOST_PACKAGE_SECTION science)
set(CPACK_DEBIAN_HOST_DESCRIPTION "water surface of a flume: receive, record, compare, plot
srd receives the coefficient frames of any number of boards that run
srd-node, records each once and in order, and draws them. It also redoes
recordings of OpenSRD, renders flumes with known truth and studies accuracy.")
set(CPACK_DEBIAN_HOST_PACKAGE_SUGGESTS flume-srd-node)

# Over a sysroot there is no package database to ask for dependencies: one is made of the packages it was unpacked from.
if(CMAKE_CROSSCOMPILING AND SRD_DEBIAN_ARCHITECTURE)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${SRD_DEBIAN_ARCHITECTURE})
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS
    ${CMAKE_SYSROOT}/usr/lib/${SRD_TRIPLET} ${CMAKE_SYSROOT}/lib/${SRD_TRIPLET})
  set(CPACK_SRD_SYSROOT ${CMAKE_SYSROOT})
  set(CPACK_SRD_ADMINDIR ${made}/dpkg)
  set(CPACK_SRD_MAKE_ADMINDIR ${packaging}/make_admindir.sh)
endif()
set(CPACK_PROJECT_CONFIG_FILE ${packaging}/cpack_options.cmake)
include(CPack)
