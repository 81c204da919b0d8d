# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Everything comes from Debian 12 packages (tools/install-dependencies.sh).
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(Ceres 2.1 REQUIRED)
# Debian's OpenCVConfig.cmake is part of libopencv-dev, which installs every module and its GUI.
# Only some modules are needed, so they are found one by one.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
set(nav_opencv_modules core imgproc)
foreach(module core imgproc)
  find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
endforeach()
if(NOT DEFINED SONDE_BUILD_CAMERA OR SONDE_BUILD_CAMERA)
  set(nav_camera_found ON)
  foreach(module aruco calib3d imgcodecs videoio)
    find_library(OPENCV_${module}_LIBRARY opencv_${module})
    if(NOT OPENCV_${module}_LIBRARY)
      set(nav_camera_found OFF)
    endif()
  endforeach()
  if(nav_camera_found)
    list(APPEND nav_opencv_modules aruco calib3d imgcodecs videoio)
  elseif(DEFINED SONDE_BUILD_CAMERA)
    message(STATUS "cameras: not built, because OpenCV's videoio, calib3d or aruco was not found")
    set(SONDE_BUILD_CAMERA OFF)
  endif()
else()
  message(STATUS "cameras: not built (SONDE_BUILD_CAMERA=OFF)")
endif()
foreach(module ${nav_opencv_modules})
  add_library(opencv::${module} UNKNOWN IMPORTED)
  set_target_properties(
    opencv::${module} PROPERTIES IMPORTED_LOCATION ${OPENCV_${module}_LIBRARY}
                                 INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE_DIR})
endforeach()
# libwebp and its animation encoder have pkg-config files only.
find_path(WEBP_INCLUDE_DIR webp/mux.h REQUIRED)
foreach(module webp webpmux)
  find_library(WEBP_${module}_LIBRARY ${module} REQUIRED)
  add_library(webp::${module} UNKNOWN IMPORTED)
  set_target_properties(
    webp::${module} PROPERTIES IMPORTED_LOCATION ${WEBP_${module}_LIBRARY}
                               INTERFACE_INCLUDE_DIRECTORIES ${WEBP_INCLUDE_DIR})
endforeach()
find_package(glm REQUIRED)
find_package(OpenGL REQUIRED COMPONENTS OpenGL EGL GLX)
find_package(X11 REQUIRED) # Only to test whether there is a display: VTK aborts without one.
find_path(USB_INCLUDE_DIR libusb-1.0/libusb.h REQUIRED)
find_library(USB_LIBRARY usb-1.0 REQUIRED)
add_library(usb::usb UNKNOWN IMPORTED)
set_target_properties(usb::usb PROPERTIES IMPORTED_LOCATION ${USB_LIBRARY}
                                          INTERFACE_INCLUDE_DIRECTORIES ${USB_INCLUDE_DIR})
find_package(CLI11 REQUIRED)
find_package(spdlog REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(pugixml REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(
  VTK 9.1 REQUIRED
  COMPONENTS CommonCore
             CommonDataModel
             CommonExecutionModel
             FiltersSources
             IOGeometry
             IOImage
             InteractionStyle
             RenderingCore
             RenderingFreeType
             RenderingOpenGL2
             RenderingUI
             RenderingVolume
             RenderingVolumeOpenGL2
             glew
             opengl)
find_package(DICOM REQUIRED)
if(SONDE_BUILD_WINDOW)
  find_package(Qt6 6.2 QUIET COMPONENTS Widgets)
  if(Qt6Widgets_FOUND)
    message(STATUS "sonde-window: built with Qt ${Qt6Widgets_VERSION}")
  else()
    message(STATUS "sonde-window: not built, because Qt 6 Widgets (qt6-base-dev) was not found")
    set(SONDE_BUILD_WINDOW OFF)
  endif()
elseif(DEFINED SONDE_BUILD_WINDOW)
  message(STATUS "sonde-window: not built (SONDE_BUILD_WINDOW=OFF)")
endif()
if(SONDE_BUILD_TESTS)
  find_package(GTest 1.12 REQUIRED)
endif()
if(SONDE_BUILD_BENCH)
  find_package(benchmark REQUIRED)
endif()
