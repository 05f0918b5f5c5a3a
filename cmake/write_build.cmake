# cmake -D SOURCE=FOLDER -D OUTPUT=HEADER -D GIT=PROGRAM -D COMPILER=TEXT -D FLAGS=TEXT -P write_build.cmake: writes what a build is made
# from: commit and state of the clone, compiler and flags. Without a clone the commit is that of the archive, or `unknown`.
set(commit unknown)
set(is_dirty false)
set(top)
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE} rev-parse --show-toplevel --verify HEAD OUTPUT_VARIABLE found RESULT_VARIABLE failed
                  ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT failed AND "${found}" MATCHES "^(.*)\n([0-9a-f]+)$")
    set(found_commit ${CMAKE_MATCH_2})
    file(REAL_PATH "${CMAKE_MATCH_1}" top)
  endif()
endif()
file(REAL_PATH "${SOURCE}" source)
# A clone around the sources is of another project.
if("${top}" STREQUAL "${source}")
  set(commit ${found_commit})
  execute_process(COMMAND ${GIT} --no-optional-locks -C ${SOURCE} status --porcelain --untracked-files=no OUTPUT_VARIABLE changes
                  RESULT_VARIABLE failed ERROR_QUIET)
  if(failed OR NOT "${changes}" STREQUAL "")
    set(is_dirty true)
  endif()
else()
  file(READ ${SOURCE}/cmake/source_commit.txt archived)
  string(STRIP "${archived}" archived)
  if("${archived}" MATCHES "^[0-9a-f]+$")
    set(commit ${archived})
  endif()
endif()
set(text "// Made by cmake/write_build.cmake.
#pragma once

#define TACTOR_COMMIT \"${commit}\"
#define TACTOR_IS_DIRTY ${is_dirty}
#define TACTOR_COMPILER \"${COMPILER}\"
#define TACTOR_FLAGS \"${FLAGS}\"
")
# An unchanged file is left alone, so that nothing is compiled for it.
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "${text}" @ONLY)
