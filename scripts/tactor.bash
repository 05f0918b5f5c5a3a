# Completion for bash: verbs, and the options of the verb, as the command's own help names them. Files otherwise.
_tactor() {
  local word=${COMP_WORDS[COMP_CWORD]} help
  if [ "$COMP_CWORD" -eq 1 ]; then
    help=$(tactor --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z][a-z]*\) .*/\1/p')
    mapfile -t COMPREPLY < <(compgen -W "$help" -- "$word")
    return
  fi
  if [[ $word == -* ]]; then
    help=$(tactor "${COMP_WORDS[1]}" --help 2>/dev/null | grep --only-matching -e '--[a-z][a-z-]*')
    mapfile -t COMPREPLY < <(compgen -W "$help" -- "$word")
    return
  fi
  mapfile -t COMPREPLY < <(compgen -f -- "$word")
}
complete -o filenames -F _tactor tactor
