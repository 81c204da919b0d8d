# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Installs the libraries up to session/ (component sdk), so that another project can say
#   find_package(Sonde REQUIRED)
#   target_link_libraries(my_program PRIVATE Sonde::session)
set(nav_package_folders nav io tracking registration devices sim session)
set(nav_package_parts common warnings io_vtk)
if(SONDE_BUILD_CAMERA)
  list(APPEND nav_package_parts devices_camera)
endif()
foreach(name ${nav_package_parts} ${nav_package_folders})
  set_target_properties(nav_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS nav_${name} EXPORT SondeTargets ARCHIVE COMPONENT sdk)
endforeach()
foreach(folder ${nav_package_folders})
  install(
    DIRECTORY ${PROJECT_SOURCE_DIR}/${folder}
    DESTINATION include/sonde
    COMPONENT sdk
    FILES_MATCHING
    PATTERN "*.hpp"
    PATTERN "detail" EXCLUDE)
endforeach()
set(nav_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Sonde)
install(EXPORT SondeTargets NAMESPACE Sonde:: DESTINATION ${nav_package_dir} COMPONENT sdk)
include(CMakePackageConfigHelpers)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/SondeConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(
  FILES ${PROJECT_SOURCE_DIR}/cmake/SondeConfig.cmake
        ${PROJECT_SOURCE_DIR}/cmake/NavDependencies.cmake
        ${CMAKE_CURRENT_BINARY_DIR}/SondeConfigVersion.cmake
  DESTINATION ${nav_package_dir}
  COMPONENT sdk)
