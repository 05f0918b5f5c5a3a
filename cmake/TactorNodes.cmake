# For projects that build on an installation of Tactor: node libraries, and graphs as tests.

set(TACTOR_NODE_OUTPUT ${CMAKE_BINARY_DIR}/nodes)

# tactor_add_nodes(NAME SOURCES ... [LIBS ...]): the nodes of type `NAME.*`, as the library libtactor_NAME.so in the folder
# `nodes` of the build. One of the sources has TACTOR_NODES. It is compiled as Tactor itself is: in C++20, without the
# contraction of a * b + c, so that debug and release builds give the same numbers. Calls of std::sin and its like go to
# tactor::portable_math, so that all processors give the same numbers. The archive is linked whole: an object of it that is only
# taken where it is missed would come too late, after the C library.
# `cmake --install BUILD --prefix ~/.local` puts it where every graph of yours finds it.
function(tactor_add_nodes name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  if(NOT name MATCHES "^[a-z][a-z0-9_]*$")
    message(FATAL_ERROR "tactor_add_nodes: expected a name of small letters, digits and _, found \"${name}\"; it is what stands "
                        "before the dot of a node type")
  endif()
  if(NOT ARG_SOURCES OR ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "tactor_add_nodes(${name}): expected SOURCES file... [LIBS target...], found \"${ARGN}\"")
  endif()
  add_library(tactor_${name} MODULE ${ARG_SOURCES})
  target_link_libraries(tactor_${name} PRIVATE $<LINK_LIBRARY:WHOLE_ARCHIVE,tactor::portable_math> tactor::tactor ${ARG_LIBS})
  target_compile_features(tactor_${name} PRIVATE cxx_std_20)
  target_compile_options(tactor_${name} PRIVATE -ffp-contract=off)
  set_target_properties(tactor_${name} PROPERTIES PREFIX lib CXX_EXTENSIONS OFF LIBRARY_OUTPUT_DIRECTORY ${TACTOR_NODE_OUTPUT})
  install(TARGETS tactor_${name} LIBRARY DESTINATION share/tactor/nodes)
endfunction()

# tactor_test_graph(NAME GRAPH [OPTION...]): a test that runs a graph with the nodes of this build, as
# `tactor run GRAPH OPTION...` does. It fails where the run does.
function(tactor_test_graph name graph)
  add_test(NAME ${name} COMMAND ${TACTOR_COMMAND} run ${CMAKE_CURRENT_SOURCE_DIR}/${graph} --out ${CMAKE_BINARY_DIR}/out/${name}
                                --overwrite ${ARGN})
  set_tests_properties(${name} PROPERTIES ENVIRONMENT "TACTOR_NODE_PATH=${TACTOR_NODE_OUTPUT};TACTOR_CACHE=${CMAKE_BINARY_DIR}/cache")
endfunction()
