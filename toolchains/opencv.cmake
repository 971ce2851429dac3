# SPDX-License-Identifier: Apache-2.0
# OpenCV's parts as imported targets srd::opencv_<module>, found one by one: Debian keeps OpenCVConfig.cmake in a
# package that pulls in a gigabyte (viz, VTK, Qt), and the parts used here are small. A board needs the core alone.
find_path(SRD_OPENCV_INCLUDE opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(module core imgproc calib3d imgcodecs)
  find_library(SRD_OPENCV_${module} opencv_${module})
  if(SRD_OPENCV_${module})
    add_library(srd::opencv_${module} UNKNOWN IMPORTED)
    set_target_properties(srd::opencv_${module} PROPERTIES
      IMPORTED_LOCATION ${SRD_OPENCV_${module}}
      INTERFACE_INCLUDE_DIRECTORIES ${SRD_OPENCV_INCLUDE})
    if(NOT module STREQUAL core)
      target_link_libraries(srd::opencv_${module} INTERFACE srd::opencv_core)
    endif()
  elseif(module STREQUAL core OR SRD_BUILD_HOST)
    message(FATAL_ERROR "OpenCV's ${module} is missing: install libopencv-${module}-dev")
  endif()
endforeach()
