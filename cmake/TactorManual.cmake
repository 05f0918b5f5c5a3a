# Manual pages, which the command writes from its own declarations, and completion for bash, zsh and fish.
set(TACTOR_MANUAL ${CMAKE_BINARY_DIR}/man)
set(pack)
set(TACTOR_MANUAL_ENDING 1)
set(zsh_folder zsh/site-functions)
if(TACTOR_PACKAGES)
  find_program(TACTOR_GZIP gzip REQUIRED)
  # Debian wants them compressed.
  set(pack COMMAND sh -c "${TACTOR_GZIP} -9n ${TACTOR_MANUAL}/*.1")
  set(TACTOR_MANUAL_ENDING 1.gz)
  set(zsh_folder zsh/vendor-completions)
endif()
add_custom_command(OUTPUT ${TACTOR_MANUAL}/tactor.${TACTOR_MANUAL_ENDING}
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${TACTOR_MANUAL}
  COMMAND tactor_command reference --man ${TACTOR_MANUAL}
  ${pack}
  DEPENDS tactor_command
  COMMENT "Writing the manual pages" VERBATIM)
add_custom_target(tactor_manual ALL DEPENDS ${TACTOR_MANUAL}/tactor.${TACTOR_MANUAL_ENDING})
install(DIRECTORY ${TACTOR_MANUAL}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)

set(completion ${CMAKE_SOURCE_DIR}/scripts/completion)
install(FILES ${completion}/tactor.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME tactor)
install(FILES ${completion}/_tactor DESTINATION ${CMAKE_INSTALL_DATADIR}/${zsh_folder})
install(FILES ${completion}/tactor.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
