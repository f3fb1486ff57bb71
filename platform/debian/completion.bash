# Completion of polhode in bash. Commands and options are those of the program's own --help.
_polhode() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} word help commands=()
  case $previous in
    --config | --sequence | --out | --commands | --checkpoint | --key)
      mapfile -t COMPREPLY < <(compgen -f -- "$current")
      return ;;
    --wait)
      mapfile -t COMPREPLY < <(compgen -W 'unix: udp: shm:/ file:' -- "$current")
      return ;;
  esac
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    case $word in
      -*) break ;;
      *) commands+=("$word") ;;
    esac
  done
  help=$("${COMP_WORDS[0]}" "${commands[@]}" --help 2>/dev/null) || return
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -oE '(^|[ ,])--[a-z][a-z-]*' <<< "$help" | tr -d ' ,')" -- "$current")
  else
    mapfile -t COMPREPLY < <(compgen -f -W "$(sed -n '/^Subcommands:/,$s/^  \([a-z]\+\) .*/\1/p' <<< "$help")" -- "$current")
  fi
}
complete -o filenames -F _polhode polhode
