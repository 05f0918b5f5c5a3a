#!/bin/sh
# status.sh JOB...: a line for each job that lives: `JOB waiting` until its tasks begin, then `JOB running`.
set -u
for job in "$@"; do
  process=${job%-*}
  [ "$(cut -d ' ' -f 22 "/proc/$process/stat" 2>/dev/null)" = "${job#*-}" ] || continue
  case $(cut -d ' ' -f 2,3 "/proc/$process/stat" 2>/dev/null) in
    *' Z') ;;
    '(xargs)'*) echo "$job running" ;;
    *) echo "$job waiting" ;;
  esac
done
