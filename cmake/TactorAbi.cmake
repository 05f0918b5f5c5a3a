# What the libraries and the program share, as a number: the hash of the headers that both are compiled with, and of the compiler.
# A library that was compiled with others is refused when it is loaded. Made when something is built, not by hand.
file(GLOB_RECURSE TACTOR_ABI_HEADERS CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/framework/*.hpp ${CMAKE_SOURCE_DIR}/nodes/physics/*.hpp
     ${CMAKE_SOURCE_DIR}/app/view/view_server.hpp)
set(TACTOR_ABI_FOLDER ${CMAKE_BINARY_DIR}/generated)
string(JOIN "\n" headers ${TACTOR_ABI_HEADERS})
file(CONFIGURE OUTPUT ${TACTOR_ABI_FOLDER}/abi_headers.txt CONTENT "${headers}\n")
add_custom_command(
  OUTPUT ${TACTOR_ABI_FOLDER}/tactor_abi.hpp
  COMMAND ${CMAKE_COMMAND} -D LIST=${TACTOR_ABI_FOLDER}/abi_headers.txt -D OUTPUT=${TACTOR_ABI_FOLDER}/tactor_abi.hpp
          -D "COMPILER=${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION} ${TACTOR_SANITIZE}" -P ${CMAKE_SOURCE_DIR}/cmake/write_abi.cmake
  DEPENDS ${TACTOR_ABI_HEADERS} ${CMAKE_SOURCE_DIR}/cmake/write_abi.cmake
  VERBATIM)
add_custom_target(tactor_abi DEPENDS ${TACTOR_ABI_FOLDER}/tactor_abi.hpp)

# tactor_states_abi(TARGET): one of its sources includes tactor_abi.hpp.
function(tactor_states_abi target)
  add_dependencies(${target} tactor_abi)
  target_include_directories(${target} PRIVATE ${TACTOR_ABI_FOLDER})
endfunction()
