#!/bin/sh
# Minutes of load on a server built with a sanitizer, shadows of every technique with it, and then
# an end by SIGTERM: what the sanitizer has to say about the server fails this.
#
#   sanitized_load.sh PENUMBRAD PENUMBRA_LOAD PENUMBRA SCENE [SECONDS]     # 300 seconds by default
set -eu

penumbrad=$1 load=$2 penumbra=$3 scene=$4 seconds=${5-300}
folder=$(mktemp -d)
server= bakes=
trap 'kill $server $bakes 2> "$folder/why" || true; wait; rm -rf "$folder"' EXIT

# What the sanitizer says is in files of its own. Instrumented, the server is late by any measure.
report=log_path=$folder/report:halt_on_error=0
ASAN_OPTIONS=$report:${ASAN_OPTIONS-} UBSAN_OPTIONS=$report:print_stacktrace=1:${UBSAN_OPTIONS-} \
TSAN_OPTIONS=$report:${TSAN_OPTIONS-} \
  "$penumbrad" --listen 127.0.0.1:0 --data-dir "$folder/data" --address-file "$folder/address" \
  --max-read-delay 0 > "$folder/log" 2>&1 &
server=$!
while [ ! -s "$folder/address" ]; do
  kill -0 "$server" || { cat "$folder/log" "$folder"/report* || true; exit 1; }
  sleep 0.1
done
address=$(cat "$folder/address")

# One bake after another, until the load is over.
bake() {
  technique=$1
  shift
  [ ! -e "$folder/over" ] || return 0
  if "$penumbra" bake "$scene" --server "$address" --technique "$technique" "$@" \
    --out "$folder/$technique" > "$folder/baked" 2>&1; then
    echo "$technique" >> "$folder/done"
  else
    cat "$folder/baked"
    : > "$folder/failed"
  fi
}
while [ ! -e "$folder/over" ] && [ ! -e "$folder/failed" ]; do
  bake soft_texture --floor --size 64x64
  bake layered_attenuation --set resolution=64
  bake shadow_width --set resolution=128
  bake shadow_volume --set resolution=128
  bake coherent_raytrace --picture 64x64 --samples 16
done &
bakes=$!

status=0
"$load" --server "$address" --clients 40 --scenes 10 --viewers 8 --rate 50 --max-late 10000 \
  --seconds "$seconds" || status=1
: > "$folder/over"
wait "$bakes"
bakes=
kill -TERM "$server"
wait "$server" || { echo "the server ended with status $?"; status=1; }
server=

sort "$folder/done" | uniq -c
[ "$(sort -u "$folder/done" | wc -l)" -eq 5 ] || { echo "not every technique was baked"; status=1; }
[ ! -e "$folder/failed" ] || { echo "a bake failed"; status=1; }
for found in "$folder"/report*; do
  [ -e "$found" ] || break
  cat "$found"
  status=1
done
[ "$status" -ne 0 ] || echo "nothing found in $seconds s"
exit "$status"
