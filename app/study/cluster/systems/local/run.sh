#!/bin/sh
# run.sh SCRIPT LOG FIRST LAST AT_ONCE [JOB...]: what submit.sh leaves running. It runs the script that submit.sh has opened,
# whatever stands in its place by then.
set -u
here=$(dirname "$0")
first=$3 last=$4 at_once=$5
shift 5
while [ $# -gt 0 ] && [ -n "$(sh "$here/status.sh" "$@")" ]; do
  sleep 0.1
done
# xargs would end where a task is killed, and the others are to go on.
exec xargs -a /dev/fd/3 -n 1 -P "$at_once" sh -c 'TACTOR_TASK=$1 sh /dev/fd/4 || :' sh 3<<INDICES
$(seq "$first" "$last")
INDICES
