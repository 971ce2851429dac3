# OpenCV's parts as imported targets srd::opencv_<module>, found one by one: Debian keeps OpenCVConfig.cmake in a
# package that pulls in a gigabyte (viz, VTK, Qt), and the parts used here are small.
find_path(SRD_OPENCV_INCLUDE opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(module core imgproc imgcodecs calib3d)
  find_library(SRD_OPENCV_${module} opencv_${module} REQUIRED)
  add_library(srd::opencv_${module} UNKNOWN IMPORTED)
  set_target_properties(srd::opencv_${module} PROPERTIES
    IMPORTED_LOCATION ${SRD_OPENCV_${module}}
    INTERFACE_INCLUDE_DIRECTORIES ${SRD_OPENCV_INCLUDE})
endforeach()
foreach(module imgproc imgcodecs calib3d)
  target_link_libraries(srd::opencv_${module} INTERFACE srd::opencv_core)
endforeach()
