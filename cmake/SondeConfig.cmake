# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Configuration for find_package(Sonde). The packages that Sonde is made of must be installed.
include(${CMAKE_CURRENT_LIST_DIR}/NavDependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/SondeTargets.cmake)
