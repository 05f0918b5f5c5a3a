#!/bin/sh
# cancel.sh JOB...: asks all processes of each job that lives to end.
set -u
here=$(dirname "$0")
sh "$here/status.sh" "$@" | while read -r job state; do
  kill -TERM "-${job%-*}"
done
