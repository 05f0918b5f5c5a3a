# cmake -D LIST=FILE -D OUTPUT=HEADER -D COMPILER=TEXT -P write_abi.cmake: writes TACTOR_ABI, as a text the hash of the files that LIST names.
file(STRINGS ${LIST} headers)
set(all "${COMPILER}")
foreach(header ${headers})
  file(SHA256 ${header} hash)
  string(APPEND all " ${hash}")
endforeach()
string(SHA256 hash "${all}")
string(SUBSTRING ${hash} 0 16 number)
set(text "// Made by cmake/write_abi.cmake.\n#pragma once\n\n#define TACTOR_ABI \"${number}\"\n")
# An unchanged file is left alone, so that nothing is compiled for it.
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "${text}" @ONLY)
