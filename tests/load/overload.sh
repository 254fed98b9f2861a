#!/bin/sh
# Four times the load that a server can carry, with its scenes on disk and 1 GiB of memory: a control
# group's limit where this machine lets us make one, else its greatest resident size is looked at.
#
#   overload.sh PENUMBRAD PENUMBRA_LOAD [OPTION...]     # options of penumbra_load
set -eu

penumbrad=$1 load=$2
shift 2
folder=$(mktemp -d)
server=
group=
trap '[ -z "$server" ] || kill "$server"; wait; [ -z "$group" ] || rmdir "$group"; rm -rf "$folder"' EXIT

# In the group from its first instruction on, where there is one.
memory=$((1 << 30))
for parent in /sys/fs/cgroup/memory /sys/fs/cgroup; do
  group=$parent/penumbra_overload_$$
  mkdir "$group" 2> "$folder/why" || { group=; continue; }
  limit=$group/memory.limit_in_bytes
  [ -e "$limit" ] || limit=$group/memory.max
  if [ -e "$limit" ] && echo "$memory" > "$limit"; then break; fi
  rmdir "$group"
  group=
done 2> "$folder/why"
echo "control group: ${group:-none, the resident size counts}"

sh -c '[ -z "$1" ] || echo $$ > "$1/cgroup.procs"; shift; exec "$@"' sh "$group" \
  "$penumbrad" --listen 127.0.0.1:0 --data-dir "$folder/data" --address-file "$folder/address" \
  > "$folder/log" 2>&1 &
server=$!
while [ ! -s "$folder/address" ]; do
  kill -0 "$server" || { cat "$folder/log"; exit 1; }
  sleep 0.1
done
"$load" --server "$(cat "$folder/address")" --overload --server-pid "$server" "$@"
