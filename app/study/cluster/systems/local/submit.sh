#!/bin/sh
# submit.sh SCRIPT LOG FIRST LAST AT_ONCE [JOB...]: starts the tasks FIRST to LAST of a script, AT_ONCE at a time, when
# the other jobs have ended. Prints the name of the job: the number of its process and when that began, so that another
# process that gets the number later is not taken for it.
set -eu
log=$2
exec 4<"$1"
here=$(dirname "$0")
setsid sh "$here/run.sh" "$@" </dev/null >>"$log" 2>&1 &
echo "$!-$(cut -d ' ' -f 22 "/proc/$!/stat")"
