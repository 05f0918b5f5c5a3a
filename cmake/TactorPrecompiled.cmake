# Headers of others that most sources include, compiled once for all sources with the same options. Where ccache is found it
# does better from the second build on, and they are left out: it keeps such sources only with settings that it does not have by
# default. Headers of ours are never among them: a change of one would compile everything anew.
option(TACTOR_PRECOMPILE "Precompile headers of the standard library, Eigen, CGAL, nlohmann-json and Boost.Test (by GCC, without ccache)" ON)
if(TACTOR_CCACHE OR NOT TACTOR_PRECOMPILE OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()

set(TACTOR_STANDARD_HEADERS <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional>
    <limits> <map> <memory> <mutex> <numbers> <numeric> <optional> <random> <set> <span> <sstream> <stdexcept> <string> <string_view>
    <thread> <tuple> <utility> <variant> <vector>)

# tactor_precompile(TARGET HEADER...): the target makes the standard headers and these, for itself and whoever uses its.
function(tactor_precompile target)
  target_precompile_headers(${target} PRIVATE ${TACTOR_STANDARD_HEADERS} ${ARGN})
endfunction()

# tactor_use_precompiled(TARGET [FROM]): the headers that the target FROM makes, by default the standard ones. Both are
# compiled with the same options; so either both are programs (-fPIE) or neither is (-fPIC).
function(tactor_use_precompiled target)
  set(from tactor_precompiled ${ARGN})
  list(GET from -1 from)
  target_precompile_headers(${target} REUSE_FROM ${from})
endfunction()

# tactor_precompile_for_programs(TARGET LIBS LIBRARY... HEADERS HEADER...): an object library that makes the standard headers and these, for
# programs that link these libraries.
function(tactor_precompile_for_programs target)
  cmake_parse_arguments(ARG "" "" "LIBS;HEADERS" ${ARGN})
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(${target} PRIVATE ${ARG_LIBS})
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  target_compile_options(${target} PRIVATE -fPIE)
  tactor_precompile(${target} ${ARG_HEADERS})
endfunction()
