#!/bin/sh
# Configures and builds a preset of CMakePresets.json, with progress.
#
#   deploy/build.sh release penumbra penumbrad    # those two programs
#   deploy/build.sh ci                            # everything
set -eu

cd "$(dirname "$0")/.."

[ $# -gt 0 ] || { echo "build: name a preset: release, dev, ci, asan, tsan or fuzz" >&2; exit 1; }
preset=$1
shift

for folder in . build "build/$preset"; do
  if [ -d "$folder" ] && [ ! -w "$folder" ]; then
    echo "build: $folder is not writable for $(id -un); an earlier build by another user?" \
      "Remove build/ or run as that user." >&2
    exit 1
  fi
done

# As many compilers as there are processors, but no more than memory holds: a translation unit that
# includes gRPC takes up to 1.2 GB under a sanitizer.
jobs=$(awk -v cores="$(nproc)" '
  /^MemAvailable:/ { fits = int($2 / 1200000) }
  END { if (fits < 1) fits = 1; print fits < cores ? fits : cores }' /proc/meminfo)

export NINJA_STATUS='[%f/%t, %es] '
echo "build: preset $preset, $jobs at a time"
cmake --preset "$preset" --log-level=WARNING
if [ $# -gt 0 ]; then
  cmake --build --preset "$preset" -j "$jobs" --target "$@"
else
  cmake --build --preset "$preset" -j "$jobs"
fi
