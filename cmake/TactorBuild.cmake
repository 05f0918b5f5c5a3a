# The plugin tactor_build: commit, compiler and flags, which `tactor --version` and every result tell. It is a library by itself, so that
# another commit compiles one file and leaves programs and libraries the same to the byte. It tells no date and no folder, so that the
# same commit gives the same library.
find_package(Git QUIET)
get_target_property(TACTOR_BUILD_FLAGS tactor_flags INTERFACE_COMPILE_OPTIONS)
string(TOUPPER "${CMAKE_BUILD_TYPE}" TACTOR_BUILD_TYPE)
list(PREPEND TACTOR_BUILD_FLAGS "${CMAKE_CXX_FLAGS}" "${CMAKE_CXX_FLAGS_${TACTOR_BUILD_TYPE}}")
string(JOIN " " TACTOR_BUILD_FLAGS ${TACTOR_BUILD_FLAGS})
separate_arguments(TACTOR_BUILD_FLAGS)
# Warnings and the compiler's own memory change no code, and maps of folders name folders.
list(FILTER TACTOR_BUILD_FLAGS EXCLUDE REGEX "^(-W[^lap]|-W[lap][^,]|-w$|-W$|--param|-f[a-z]+-prefix-map=)")
list(REMOVE_DUPLICATES TACTOR_BUILD_FLAGS)
string(JOIN " " TACTOR_BUILD_FLAGS ${TACTOR_BUILD_FLAGS})
string(REGEX REPLACE "[\"\\\\]" "" TACTOR_BUILD_FLAGS "${TACTOR_BUILD_FLAGS}")
set(TACTOR_BUILD_HEADER ${TACTOR_ABI_FOLDER}/tactor_build.hpp)
# Git is asked at each build. The header changes with the commit, and when the first change appears or the last one is taken back.
add_custom_target(tactor_build_header
  BYPRODUCTS ${TACTOR_BUILD_HEADER}
  COMMAND ${CMAKE_COMMAND} -D SOURCE=${CMAKE_SOURCE_DIR} -D OUTPUT=${TACTOR_BUILD_HEADER} -D "GIT=${GIT_EXECUTABLE}"
          -D "COMPILER=${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}" -D "FLAGS=${TACTOR_BUILD_FLAGS}"
          -P ${CMAKE_SOURCE_DIR}/cmake/write_build.cmake
  COMMENT "Asking git for the commit"
  VERBATIM)
add_library(tactor_build MODULE run/build_library.cpp)
target_link_libraries(tactor_build PRIVATE tactor_framework)
tactor_use_precompiled(tactor_build)
tactor_plugin(tactor_build)
add_dependencies(tactor_build tactor_build_header)
