#!/bin/sh
# A small load on a server that keeps its scenes on disk: nothing is lost.
#
#   small_load.sh PENUMBRAD PENUMBRA_LOAD
set -eu

folder=$(mktemp -d)
server=
trap '[ -z "$server" ] || kill "$server"; wait; rm -rf "$folder"' EXIT

"$1" --listen 127.0.0.1:0 --data-dir "$folder/data" --address-file "$folder/address" \
  > "$folder/log" 2>&1 &
server=$!
while [ ! -s "$folder/address" ]; do
  kill -0 "$server" || { cat "$folder/log"; exit 1; }
  sleep 0.1
done
# The rate is one that a loaded machine keeps up with.
"$2" --server "$(cat "$folder/address")" --clients 20 --scenes 5 --viewers 8 --rate 100 --seconds 5
