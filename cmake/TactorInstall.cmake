# What others build on: libtactor, its headers, the libraries of devices and physics, and `find_package(tactor)`, which finds an
# installation or, by -DCMAKE_PREFIX_PATH=BUILD, the folder of a build with the headers of its clone.
include(CMakePackageConfigHelpers)

set(TACTOR_CMAKE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/tactor)
set(TACTOR_BUILT_CMAKE_FOLDER ${CMAKE_BINARY_DIR}/lib/cmake/tactor)
set(TACTOR_HEADER_FOLDER ${CMAKE_INSTALL_INCLUDEDIR}/tactor)

# tactor_install_component(COMPONENT TARGET...): the targets become tactor::NAME, in the component's file of targets.
function(tactor_install_component component)
  foreach(target ${ARGN})
    string(REGEX REPLACE "^(tactor|nodes)_" "" name ${target})
    if(NOT target STREQUAL "tactor_framework")
      set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
    endif()
    target_include_directories(${target} INTERFACE
      $<INSTALL_INTERFACE:${TACTOR_HEADER_FOLDER}>
      "$<BUILD_INTERFACE:$<${TACTOR_IS_OUTSIDE}:${CMAKE_SOURCE_DIR}>>"
      "$<BUILD_INTERFACE:$<${TACTOR_IS_OUTSIDE}:${TACTOR_ABI_FOLDER}>>")
    target_compile_features(${target} INTERFACE $<${TACTOR_IS_OUTSIDE}:cxx_std_20>)
  endforeach()
  set_property(GLOBAL APPEND PROPERTY TACTOR_INSTALLED_LIBRARIES ${ARGN})
  install(TARGETS ${ARGN} EXPORT tactor-${component} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} NAMELINK_COMPONENT dev
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  install(EXPORT tactor-${component} NAMESPACE tactor:: DESTINATION ${TACTOR_CMAKE_FOLDER} COMPONENT dev)
  export(EXPORT tactor-${component} NAMESPACE tactor:: FILE ${TACTOR_BUILT_CMAKE_FOLDER}/tactor-${component}.cmake)
endfunction()

tactor_install_component(framework tactor_framework tactor_portable_math)
tactor_install_component(hardware tactor_device_files tactor_hardware)
tactor_install_component(physics physics_mesh physics_geometry physics_contact physics_deformable physics_engine physics_mechanics nodes_prediction)

# Headers keep their paths, so that code reads the same here and elsewhere. Those that show HDF5, CAF or CGAL stay here.
foreach(folder framework nodes/physics nodes/prediction devices/hardware)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/${folder}/ DESTINATION ${TACTOR_HEADER_FOLDER}/${folder} COMPONENT dev
          FILES_MATCHING PATTERN *.hpp PATTERN hdf5_* EXCLUDE PATTERN cgal EXCLUDE PATTERN meshing EXCLUDE PATTERN suitesparse EXCLUDE PATTERN mujoco EXCLUDE
          REGEX "engine/live/(lane_.*|live_engine|realtime_lane)[.]hpp$" EXCLUDE)
endforeach()
install(FILES ${TACTOR_ABI_FOLDER}/tactor_abi.hpp DESTINATION ${TACTOR_HEADER_FOLDER} COMPONENT dev)

configure_package_config_file(cmake/tactor-config.cmake.in ${CMAKE_BINARY_DIR}/generated/tactor-config.cmake
  INSTALL_DESTINATION ${TACTOR_CMAKE_FOLDER} PATH_VARS CMAKE_INSTALL_BINDIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/tactor-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/generated/tactor-config.cmake ${CMAKE_BINARY_DIR}/generated/tactor-config-version.cmake
              cmake/TactorNodes.cmake DESTINATION ${TACTOR_CMAKE_FOLDER} COMPONENT dev)

# The same for the folder of this build.
function(tactor_write_built_config)
  set(CMAKE_INSTALL_BINDIR bin)
  configure_package_config_file(cmake/tactor-config.cmake.in ${TACTOR_BUILT_CMAKE_FOLDER}/tactor-config.cmake
    INSTALL_PREFIX ${CMAKE_BINARY_DIR} INSTALL_DESTINATION lib/cmake/tactor PATH_VARS CMAKE_INSTALL_BINDIR)
endfunction()
tactor_write_built_config()
configure_file(${CMAKE_BINARY_DIR}/generated/tactor-config-version.cmake ${TACTOR_BUILT_CMAKE_FOLDER}/tactor-config-version.cmake COPYONLY)
configure_file(cmake/TactorNodes.cmake ${TACTOR_BUILT_CMAKE_FOLDER}/TactorNodes.cmake COPYONLY)
