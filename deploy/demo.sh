#!/bin/sh
# Shows the main job: a headless server, and a client that streams a scene to it, moves an object and
# the light, receives soft-shadow textures and draws the scene with them.
#
#   deploy/demo.sh                  # the sample scene
#   deploy/demo.sh SCENE            # a glTF, GLB, OBJ or PLY file
#   deploy/demo.sh --build-dir DIR [SCENE]   # programs that are built already
#
# Installs what is missing, builds, runs; pictures and server.log go to out/demo/NAME. Repeatable.
set -eu

fail() {
  echo "demo: $*" >&2
  exit 1
}

build_dir=
scene=
while [ $# -gt 0 ]; do
  case "$1" in
    --build-dir) [ $# -gt 1 ] || fail "--build-dir: found nothing, need a folder"
                 build_dir=$(cd "$2" && pwd) || exit 1
                 shift ;;
    -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) fail "found '$1', need --build-dir DIR or a scene file" ;;
    *) [ -z "$scene" ] || fail "found two scenes, need one"
       [ -f "$1" ] || fail "$1: found no such file, need a glTF, GLB, OBJ or PLY file"
       scene=$(cd "$(dirname "$1")" && pwd)/$(basename "$1") ;;
  esac
  shift
done

called_from=$PWD
cd "$(dirname "$0")/.."
[ -n "$scene" ] || scene=$PWD/deploy/scenes/sample.glb
[ -f "$scene" ] || fail "$scene: found no such file, need a scene"

step() { printf '\n== %s\n' "$*"; }

if [ -z "$build_dir" ]; then
  step "packages"
  deploy/install_packages.sh build run
  step "building (preset release)"
  deploy/build.sh release penumbra penumbrad
  build_dir=$PWD/build/release
  out_root=$PWD/out/demo
else
  out_root=$called_from/out/demo
fi

name=$(basename "$scene")
out=$out_root/${name%.*}
mkdir -p "$out" 2>/dev/null && [ -w "$out" ] || fail "$out: found a folder that $(id -un) cannot write"

step "server"
# The address appears in this file once the server listens.
address_file=$(mktemp "${TMPDIR:-/tmp}/penumbra-demo.XXXXXX")
"$build_dir/server/penumbrad" --listen 127.0.0.1:0 --address-file "$address_file" --ephemeral \
  > "$out/server.log" 2>&1 &
server=$!

stop_server() {
  status=$?
  trap - EXIT INT TERM
  kill "$server" 2>/dev/null || true
  wait "$server" 2>/dev/null || true
  rm -f "$address_file"
  exit "$status"
}
trap stop_server EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

waited=0
until [ -s "$address_file" ]; do
  kill -0 "$server" 2>/dev/null || fail "the server ended: $(tail -n 1 "$out/server.log")"
  [ "$waited" -lt 300 ] || fail "the server did not listen within 30 s; see $out/server.log"
  sleep 0.1
  waited=$((waited + 1))
done
address=$(cat "$address_file")
echo "penumbrad listens on $address, log in $out/server.log"

step "client: $name"
"$build_dir/client/penumbra" demo "$scene" --server "$address" --out "$out"

step "done"
echo "pictures: $out"
ls -1 "$out" | sed 's/^/  /'
