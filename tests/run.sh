#!/bin/sh
# Runs the suite: installs what is missing, builds with warnings as errors, runs every test.
#
#   tests/run.sh               # every test
#   tests/run.sh --quick       # under five minutes: without the tests marked long
#   tests/run.sh --reliability # kills and load, some minutes each
#   tests/run.sh --fuzz [SECONDS]  # every fuzz target with libFuzzer for so long, 60 by default
#   tests/run.sh --sanitizers  # every test, and the tests of each program once more under the address,
#                              # undefined-behaviour and thread sanitizers
#
# Ends with ctest's own summary; the status is ctest's.
set -eu

cd "$(dirname "$0")/.."

mode=all
case "${1-}" in
  '') ;;
  --quick) mode=quick ;;
  --reliability) mode=reliability ;;
  --fuzz) mode=fuzz ;;
  --sanitizers) mode=sanitizers ;;
  -h | --help) sed -n '2,11s/^# \{0,1\}//p' "$0"; exit 0 ;;
  *) echo "run.sh: found '$1', need --quick, --reliability, --fuzz, --sanitizers or nothing" >&2
     exit 2 ;;
esac

step() { printf '\n== %s\n' "$*"; }

if [ "$mode" = fuzz ]; then
  deploy/install_packages.sh build run fuzz
  step "building (preset fuzz)"
  deploy/build.sh fuzz fuzz_targets
  step "fuzzing"
  exec python3 tests/fuzz/fuzz_all.py build/fuzz/tests/fuzz "${2-60}"
fi

deploy/install_packages.sh build run test

step "building (preset ci)"
deploy/build.sh ci

# Which rows of the catalogue of bad input have tests; the test lint.catalogue fails where one has none.
python3 -B tests/lint/check_catalogue.py | tail -n 1

case "$mode" in
  quick)
    step "running the tests that are not long"
    exec ctest --test-dir build/ci -LE 'long' --no-tests=error --output-on-failure -j "$(nproc)" ;;
  reliability)
    step "running the reliability tests"
    exec ctest --test-dir build/ci -L reliability --no-tests=error --verbose ;;
  all)
    step "running all tests"
    exec ctest --test-dir build/ci -LE reliability --no-tests=error --output-on-failure -j "$(nproc)" ;;
esac

for preset in asan tsan; do
  step "building (preset $preset)"
  deploy/build.sh "$preset"
done

# One run of ctest over the three builds. In a build with a sanitizer only what is to run under it
# is a test, one for each program, so nothing is to be left out here.
mkdir -p build/all
for preset in ci asan tsan; do
  echo "subdirs(\"$PWD/build/$preset\")"
done > build/all/CTestTestfile.cmake

step "running all tests, the sanitizers with them"
exec ctest --test-dir build/all --no-tests=error --output-on-failure -j "$(nproc)"
