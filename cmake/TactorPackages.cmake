# Debian packages, by `cpack` in a build of the preset `package`: tactor, tactor-cgal, tactor-suitesparse, tactor-mujoco, libtactor-dev,
# python3-tactor.
# scripts/packages makes them, and asks lintian.
# Who made the packages, as Debian writes it; -DTACTOR_MAINTAINER says otherwise.
if(NOT TACTOR_MAINTAINER)
  set(TACTOR_MAINTAINER "Tactor developers <developers@example.org>")
endif()

# What Debian asks of every package: its licence and what has changed.
find_program(TACTOR_GZIP gzip REQUIRED)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(components runtime cgal suitesparse mujoco dev python)
set(packages tactor tactor-cgal tactor-suitesparse tactor-mujoco libtactor-dev python3-tactor)
foreach(package component IN ZIP_LISTS packages components)
  set(folder ${CMAKE_BINARY_DIR}/debian/${package})
  file(MAKE_DIRECTORY ${folder})
  execute_process(COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/cmake/changelog ${PROJECT_VERSION} debian ${package} ${TACTOR_MAINTAINER}
                  OUTPUT_FILE ${folder}/changelog COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${TACTOR_GZIP} -9nfk ${folder}/changelog COMMAND_ERROR_IS_FATAL ANY)
  set(plugin_licence)
  if(package STREQUAL "tactor")
    set(plugin_licence "\nFiles: usr/lib/*/tactor/plugins/libtactor_view.so
Copyright: 2026 the Tactor developers; 2010-2025 three.js authors; 2022 Leon Sorokin (uPlot)
License: Apache-2.0 and Expat
 This plugin holds the page of the view, of which three.js and uPlot are a part. Both are under the licence that Debian calls Expat;
 its text, with their notices, is in /usr/share/doc/tactor/third_party.txt.
")
  endif()
  if(package STREQUAL "tactor-cgal")
    set(plugin_licence "\nFiles: usr/lib/*/tactor/plugins/libtactor_cgal.so usr/lib/*/tactor/plugins/libtactor_meshing.so
Copyright: the Tactor developers; the CGAL Project
License: GPL-3+
 These plugins include headers of CGAL. Each is free software: you can redistribute it and modify it under the terms of the GNU
 General Public License, version 3 or later. On Debian systems its text is in /usr/share/common-licenses/GPL-3.
")
  elseif(package STREQUAL "tactor-suitesparse")
    set(plugin_licence "\nFiles: usr/lib/*/tactor/plugins/libtactor_suitesparse.so
Copyright: the Tactor developers; Timothy A. Davis and others (SuiteSparse)
License: GPL-2+
 This plugin is linked with the supernodal part of CHOLMOD. It is free software: you can redistribute it and modify it under the
 terms of the GNU General Public License, version 2 or later. With Tactor, which is under the Apache License 2.0, that is version 3
 or later. On Debian systems the texts are in /usr/share/common-licenses/GPL-2 and /usr/share/common-licenses/GPL-3.
")
  endif()
  configure_file(cmake/debian/copyright.in ${folder}/copyright @ONLY)
  install(FILES ${folder}/copyright ${folder}/changelog.gz DESTINATION share/doc/${package} COMPONENT ${component})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "${TACTOR_MAINTAINER}")
set(CPACK_PACKAGE_VENDOR "Tactor")
# Each package has a first line of its own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
# The bunny is not ours to hand on (meshes/README.md).
set(CPACK_COMPONENTS_ALL runtime dev)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})

set(same "tactor (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME tactor)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/debian/triggers ${CMAKE_SOURCE_DIR}/cmake/debian/runtime/postinst)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "tactor-cgal, tactor-suitesparse, xdg-utils")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "gnuplot-nox | gnuplot-qt | gnuplot-x11, libcap2-bin")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "chromium | firefox-esr, libtactor-dev, python3-tactor, tactor-mujoco")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "Smooth force feedback from slow physics
A haptic device wants a force 1,000 times a second, and physics often delivers
fewer, late and unevenly. Tactor closes that gap with virtual coupling,
prediction and interpolation, chosen in a YAML file. It runs scenes live and
under a virtual clock, drives devices on USB and Modbus, and reports error
beside run time.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libtactor-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${same}, libboost-dev, libeigen3-dev, libsleef-dev, zlib1g-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "cmake, g++")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers and CMake package for nodes and programs on Tactor
Nodes, devices and message types of your own, and programs that step a graph:
find_package(tactor), tactor_add_nodes. `tactor new node NAME` writes a project
to begin with.")

if(TACTOR_WITH_CGAL)
  list(APPEND CPACK_COMPONENTS_ALL cgal)
  set(CPACK_DEBIAN_CGAL_PACKAGE_NAME tactor-cgal)
  set(CPACK_DEBIAN_CGAL_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_CGAL_PACKAGE_DEPENDS "${same}")
  set(CPACK_COMPONENT_CGAL_DESCRIPTION "Mesh checks, repair and exact collision for Tactor (GPL-3)
The plugin that checks and repairs meshes by CGAL, and collision.exact.
A program that loads it is under the GNU General Public License as a whole.
Without it Tactor takes meshes as they are.")
endif()
if(TACTOR_WITH_SUITESPARSE)
  list(APPEND CPACK_COMPONENTS_ALL suitesparse)
  set(CPACK_DEBIAN_SUITESPARSE_PACKAGE_NAME tactor-suitesparse)
  set(CPACK_DEBIAN_SUITESPARSE_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_SUITESPARSE_PACKAGE_DEPENDS "${same}")
  set(CPACK_DEBIAN_SUITESPARSE_PACKAGE_RECOMMENDS "libopenblas0-serial | libopenblas0 | libblis4")
  set(CPACK_COMPONENT_SUITESPARSE_DESCRIPTION "Fast factors for elastic bodies in Tactor (GPL-2+)
The plugin that factors the matrices of elastic bodies by CHOLMOD.
A program that loads it is under the GNU General Public License as a whole.
Without it Eigen factors them, which takes several times as long.")
endif()
if(TARGET tactor_mujoco)
  list(APPEND CPACK_COMPONENTS_ALL mujoco)
  set(CPACK_DEBIAN_MUJOCO_PACKAGE_NAME tactor-mujoco)
  set(CPACK_DEBIAN_MUJOCO_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_MUJOCO_PACKAGE_DEPENDS "${same}")
  set(CPACK_COMPONENT_MUJOCO_DESCRIPTION "MuJoCo as the physics of Tactor
The plugin that moves scenes of MuJoCo with the virtual coupling in its solver,
and that continues them between two results.")
endif()
if(TACTOR_WITH_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-tactor)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/debian/postinst ${CMAKE_SOURCE_DIR}/cmake/debian/prerm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "${same}, python3-numpy, python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3 (<< ${Python_VERSION_MAJOR}.${TACTOR_NEXT_PYTHON_MINOR})")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-h5py, python3-pandas, python3-scipy, python3-matplotlib")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Python package of Tactor: sessions, runs, studies, nodes
Runs and steps the graphs of Tactor from Python, gives every output as a numpy
array with units, and lets a graph name a Python class as a node.")
endif()

# The bill of materials is of the files as they go into the packages: stripped.
set(bill ${CMAKE_BINARY_DIR}/debian/bill.cmake)
set(staged)
foreach(package component IN ZIP_LISTS packages components)
  if(component IN_LIST CPACK_COMPONENTS_ALL)
    string(APPEND staged "\n  ${package}=\${CPACK_TEMPORARY_DIRECTORY}/${component}")
  endif()
endforeach()
file(CONFIGURE OUTPUT ${bill} @ONLY CONTENT
[[execute_process(COMMAND @Python3_EXECUTABLE@ -B @CMAKE_SOURCE_DIR@/scripts/sbom --build @CMAKE_BINARY_DIR@ --version @PROJECT_VERSION@
  --out ${CPACK_TEMPORARY_DIRECTORY}/runtime/usr/share/doc/tactor/tactor.spdx.json@staged@
  COMMAND_ERROR_IS_FATAL ANY)
]])
set(CPACK_PRE_BUILD_SCRIPTS ${bill})
include(CPack)
