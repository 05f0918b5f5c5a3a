# Settings that every target of ours shares, and the functions that make libraries, node libraries and tests.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# A build has the folders of an installation, so programs and libraries look for libtactor in the same place in both. An installer
# that changes the run path of a finished file fills the old one up with `:`, and the loader takes that for the current folder.
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR})
set(TACTOR_NODE_DIRECTORY ${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/tactor)
# Tests and tools, which are not installed.
set(CMAKE_BUILD_RPATH_USE_ORIGIN ON)

# How many sources are compiled at a time, where they are. Many at once compile sooner, and fewer sooner after a change.
if(NOT CMAKE_UNITY_BUILD_BATCH_SIZE)
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 6)
endif()

# scripts/compile_times and scripts/build_results read what each file and each program took.
foreach(rule COMPILE LINK)
  string(TOLOWER ${rule} name)
  set_property(GLOBAL PROPERTY RULE_LAUNCH_${rule} "\"${CMAKE_SOURCE_DIR}/cmake/timed_compile\" \"${CMAKE_BINARY_DIR}/${name}_times.txt\"")
endforeach()
find_program(TACTOR_CCACHE ccache)
if(TACTOR_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${TACTOR_CCACHE})
endif()

add_library(tactor_flags INTERFACE)
# Whether who links a library of ours is a project of its own, which has neither these flags nor their include folder.
set(TACTOR_IS_OUTSIDE $<NOT:$<TARGET_EXISTS:tactor_flags>>)
set(TACTOR_FLAGS_INSIDE $<BUILD_INTERFACE:$<$<TARGET_EXISTS:tactor_flags>:tactor_flags>>)
# GCC 12 sees overlapping copies in concatenated strings and unset members of std::string that are not there (its bugs
# 105651 and 105562), hence no -Wrestrict and no -Wmaybe-uninitialized.
# Options are given by designated initialisers and the rest takes its default, which -Wextra would call missing.
# No contraction to fused multiply-add: the same source gives the same numbers in debug and in release builds.
target_compile_options(tactor_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
                                              -Wno-missing-field-initializers -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(tactor_flags INTERFACE -Wno-restrict -Wno-maybe-uninitialized)
  # GCC 12 also sees accesses beyond std::string where headers are precompiled. The same warnings with and without.
  target_compile_options(tactor_flags INTERFACE -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
  # GCC looks for memory that it could use again from 1.3 GB on, not from some 100 MB on: few sources need more anyway.
  target_compile_options(tactor_flags INTERFACE --param=ggc-min-expand=30 --param=ggc-min-heapsize=1000000)
endif()
if(CMAKE_UNITY_BUILD)
  # GCC takes the unnamed namespaces of such sources, which are included, for those of a header.
  target_compile_options(tactor_flags INTERFACE -Wno-subobject-linkage)
endif()
if(TACTOR_WERROR)
  target_compile_options(tactor_flags INTERFACE -Werror)
endif()
if(TACTOR_SANITIZE)
  # A finding of the undefined-behaviour sanitizer ends the program, so that it fails the test that found it.
  target_compile_options(tactor_flags INTERFACE -fsanitize=${TACTOR_SANITIZE} -fno-sanitize-recover=all
                                                -fno-omit-frame-pointer)
  target_link_options(tactor_flags INTERFACE -fsanitize=${TACTOR_SANITIZE})
endif()
# gold links faster than GNU's own linker. Debian has both in one package.
find_program(TACTOR_GOLD ld.gold)
if(TACTOR_GOLD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_link_options(tactor_flags INTERFACE -fuse-ld=gold)
endif()
target_include_directories(tactor_flags INTERFACE ${CMAKE_SOURCE_DIR})

include(TactorPrecompiled)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/precompiled.cpp CONTENT "")
add_library(tactor_precompiled OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
target_link_libraries(tactor_precompiled PRIVATE tactor_flags)
tactor_precompile(tactor_precompiled)

# tactor_library(NAME SOURCES ... [LIBS ...] [PRECOMPILE HEADER... | PRECOMPILED_BY TARGET]): a static library of ours; LIBS
# are linked publicly. It precompiles these headers, or uses those of another target.
function(tactor_library name)
  cmake_parse_arguments(ARG "" "PRECOMPILED_BY" "SOURCES;LIBS;PRECOMPILE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC ${TACTOR_FLAGS_INSIDE} ${ARG_LIBS})
  if(ARG_PRECOMPILE)
    tactor_precompile(${name} ${ARG_PRECOMPILE})
  else()
    tactor_use_precompiled(${name} ${ARG_PRECOMPILED_BY})
  endif()
endfunction()

# tactor_cgal_sources(TARGET OBJECTS SOURCES ... [PRECOMPILED_BY OTHER]): sources of a library or program that include CGAL. They
# alone are compiled with the options that it asks for, as the object library OBJECTS.
function(tactor_cgal_sources target objects)
  cmake_parse_arguments(ARG "" "PRECOMPILED_BY" "SOURCES" ${ARGN})
  add_library(${objects} OBJECT ${ARG_SOURCES})
  # A source takes longer than most, and gigabytes.
  set_target_properties(${objects} PROPERTIES UNITY_BUILD_BATCH_SIZE 4)
  target_link_libraries(${objects} PRIVATE tactor_framework Eigen3::Eigen CGAL::CGAL)
  if(ARG_PRECOMPILED_BY)
    tactor_use_precompiled(${objects} ${ARG_PRECOMPILED_BY})
  endif()
  target_sources(${target} PRIVATE $<TARGET_OBJECTS:${objects}>)
  target_link_libraries(${target} PRIVATE $<LINK_ONLY:CGAL::CGAL>)
endfunction()

# tactor_finds_libraries(TARGET FOLDER): TARGET, which is installed, looks for our libraries in FOLDER, relative to its own.
# In a Debian package it has no run path: there they are where every program looks.
function(tactor_finds_libraries target folder)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/${folder}")
  if(NOT CMAKE_SKIP_INSTALL_RPATH)
    set_target_properties(${target} PROPERTIES BUILD_WITH_INSTALL_RPATH ON)
  endif()
endfunction()

# tactor_program(TARGET): a program that is installed.
function(tactor_program target)
  tactor_finds_libraries(${target} ../${CMAKE_INSTALL_LIBDIR})
  install(TARGETS ${target})
endfunction()

# tactor_plugin(TARGET [COMPONENT COMPONENT]): a module that libtactor loads where a run needs it.
function(tactor_plugin target)
  tactor_states_abi(${target})
  tactor_finds_libraries(${target} ../..)
  set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${TACTOR_NODE_DIRECTORY}/plugins)
  install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/tactor/plugins ${ARGN})
endfunction()

# tactor_cgal_plugin(PLUGIN LIBRARY): the module PLUGIN, made of plugin.cpp in the caller's folder and of LIBRARY.
function(tactor_cgal_plugin plugin library)
  add_library(${plugin} MODULE plugin.cpp)
  target_link_libraries(${plugin} PRIVATE ${library})
  tactor_use_precompiled(${plugin})
  tactor_plugin(${plugin} COMPONENT cgal)
endfunction()

# tactor_node_library(PREFIX SOURCES ... [LIBS ...] [PRECOMPILED_BY TARGET]): nodes of type `PREFIX.*`. Makes the static library
# nodes_PREFIX, which tests link, and the module libtactor_PREFIX.so, which a graph loads. `register.cpp` in the
# caller's folder lists the node types.
function(tactor_node_library prefix)
  cmake_parse_arguments(ARG "" "PRECOMPILED_BY" "SOURCES;LIBS" ${ARGN})
  tactor_library(nodes_${prefix} SOURCES ${ARG_SOURCES} LIBS tactor_framework ${ARG_LIBS} PRECOMPILED_BY ${ARG_PRECOMPILED_BY})
  add_library(tactor_${prefix} MODULE register.cpp)
  target_link_libraries(tactor_${prefix} PRIVATE nodes_${prefix})
  tactor_states_abi(tactor_${prefix})
  tactor_use_precompiled(tactor_${prefix})
  tactor_finds_libraries(tactor_${prefix} ..)
  set_target_properties(tactor_${prefix} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${TACTOR_NODE_DIRECTORY})
  install(TARGETS tactor_${prefix} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/tactor)
  set_property(GLOBAL APPEND PROPERTY TACTOR_NODE_LIBRARIES tactor_${prefix})
endfunction()

# tactor_profiles(KIND): the profiles in the caller's folder `profiles`, for devices on that kind of line. They are found
# beside the program, as meshes are.
function(tactor_profiles kind)
  file(GLOB profiles CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/profiles/*.yaml)
  foreach(profile ${profiles})
    get_filename_component(name ${profile} NAME)
    configure_file(${profile} ${CMAKE_BINARY_DIR}/profiles/${kind}/${name} COPYONLY)
  endforeach()
  install(FILES ${profiles} DESTINATION ${CMAKE_INSTALL_DATADIR}/tactor/profiles/${kind})
endfunction()

# tactor_test_program(NAME [SLOWER] [SOURCES ...] [LIBS ...] [LOADS ...]): test_NAME, the program of all Boost.Test suites of the caller's
# folder, to which tactor_test adds. SOURCES are no suites. LOADS: targets that it loads while it runs, of those that there are.
# SLOWER: `scripts/test --quick` leaves it out.
function(tactor_test_program name)
  cmake_parse_arguments(ARG "SLOWER" "" "SOURCES;LIBS;LOADS" ${ARGN})
  add_executable(test_${name} ${ARG_SOURCES})
  target_link_libraries(test_${name} PRIVATE test_main ${ARG_LIBS})
  tactor_use_precompiled(test_${name} test_precompiled)
  foreach(target ${ARG_LOADS})
    if(TARGET ${target})
      add_dependencies(test_${name} ${target})
    endif()
  endforeach()
  set_target_properties(test_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(NOT ARG_SLOWER)
    add_dependencies(quick_tests test_${name})
  endif()
  set(test_program test_${name} PARENT_SCOPE)
  set(test_program_is_slower ${ARG_SLOWER} PARENT_SCOPE)
endfunction()

# tactor_test(NAME [SOURCES FILE_test.cpp...]): what ctest runs as NAME: the suites of these files, by default of NAME_test.cpp, in the
# folder's program. A file has one suite, which has the file's name, so that what helps it is no other file's.
function(tactor_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES" ${ARGN})
  if(NOT ARG_SOURCES)
    set(ARG_SOURCES ${name}_test.cpp)
  endif()
  target_sources(${test_program} PRIVATE ${ARG_SOURCES})
  list(TRANSFORM ARG_SOURCES REPLACE "\\.cpp$" "")
  tactor_suite_test(${name} ${test_program} ${ARG_SOURCES})
endfunction()

# tactor_suite_test(NAME PROGRAM SUITE...): what ctest runs as NAME: suites of a program.
function(tactor_suite_test name program)
  list(JOIN ARGN "," suites)
  # A suite that is named runs what is disabled in it too, but for what is left out by its label.
  add_test(NAME ${name} COMMAND ${program} --run_test=${suites} --run_test=!@minutes --color_output=no)
  # What tests keep in the cache is not the user's.
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 PROCESSORS 2 ENVIRONMENT TACTOR_CACHE=${CMAKE_BINARY_DIR}/tests/cache)
  if(NOT test_program_is_slower)
    set_tests_properties(${name} PROPERTIES LABELS quick)
  endif()
endfunction()

# tactor_waiting_tests(NAME...): tests that mostly wait, so that more of them run at once.
function(tactor_waiting_tests)
  set_tests_properties(${ARGN} PROPERTIES PROCESSORS 1)
endfunction()

# tactor_slower_tests(NAME...): suites that `scripts/test --quick` leaves out.
function(tactor_slower_tests)
  set_property(TEST ${ARGN} PROPERTY LABELS)
endfunction()

# tactor_thorough_tests(NAME...): tests that `scripts/test --all` alone runs.
function(tactor_thorough_tests)
  set_property(TEST ${ARGN} APPEND PROPERTY LABELS all)
endfunction()

# tactor_live_tests(NAME... [QUIET NAME...]): tests in real time. They mostly wait, so that `scripts/test` runs several at once, beside
# those that compute. Those after QUIET measure times, and come last, alone.
function(tactor_live_tests)
  cmake_parse_arguments(ARG "" "" "QUIET" ${ARGN})
  tactor_waiting_tests(${ARG_UNPARSED_ARGUMENTS} ${ARG_QUIET})
  set_tests_properties(${ARG_UNPARSED_ARGUMENTS} ${ARG_QUIET} PROPERTIES LABELS live)
  if(ARG_QUIET)
    set_tests_properties(${ARG_QUIET} PROPERTIES RUN_SERIAL ON LABELS "live;quiet")
  endif()
endfunction()

# tactor_add_parts(): every folder here that has a CMakeLists.txt.
function(tactor_add_parts)
  file(GLOB parts LIST_DIRECTORIES true CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*)
  foreach(part ${parts})
    if(EXISTS ${part}/CMakeLists.txt)
      add_subdirectory(${part})
    endif()
  endforeach()
endfunction()
