# Completion for bash: `tactor complete` says what may follow.
_tactor() {
  local word=${COMP_WORDS[COMP_CWORD]} one
  local command=${1:-tactor}
  local -a words=()
  # Bash takes `=` for a word of its own.
  for one in "${COMP_WORDS[@]:1:COMP_CWORD}"; do
    [ "$one" = "=" ] || words+=("$one")
  done
  [ "$word" != "=" ] || { word=; words+=(""); }
  COMPREPLY=()
  while IFS=$'\t' read -r one _; do
    case $one in
      :files) mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "$word") ;;
      :folders) mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -d -- "$word") ;;
      *) COMPREPLY+=("$one") ;;
    esac
  done < <("${command/#\~/$HOME}" complete -- "${words[@]}" 2>/dev/null)
}
complete -o filenames -F _tactor tactor
