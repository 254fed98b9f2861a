#!/bin/sh
# Installs the Debian packages that are missing from the named sections of deploy/packages.txt.
#
#   deploy/install_packages.sh build run        # what deploy/demo.sh needs
#   deploy/install_packages.sh build run test   # what tests/run.sh needs
#   deploy/install_packages.sh build run fuzz   # what tests/run.sh --fuzz needs
#
# Runs apt-get as root or through sudo, and not at all when nothing is missing.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
list=$here/packages.txt

fail() {
  echo "install_packages: $*" >&2
  exit 1
}

# Lines "PACKAGE COMMAND" of the sections given; COMMAND is - where a line names none.
wanted() {
  awk -v sections=" $* " '
    /^#/ || NF == 0 { next }
    /^\[/ { gsub(/[][]/, ""); wanted = index(sections, " " $1 " "); next }
    wanted { command = "-"; if ($2 ~ /^command=/) command = substr($2, 9); print $1, command }
  ' "$list"
}

is_installed() {
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

[ $# -gt 0 ] || fail "name the sections of packages.txt to install: build, run, test, fuzz"
for section in "$@"; do
  grep -qx "\[$section\]" "$list" ||
    fail "found section '$section', need one of build, run, test, fuzz"
done
command -v dpkg-query >/dev/null && command -v apt-get >/dev/null ||
  fail "no apt-get here: Penumbra installs on Debian 12; elsewhere install the equivalents of $list"

missing=$(wanted "$@" | while read -r package command; do
  if [ "$command" != - ] && command -v "$command" >/dev/null; then continue; fi
  is_installed "$package" || printf '%s ' "$package"
done)
if [ -z "$missing" ]; then
  echo "packages: all there"
  exit 0
fi

if [ "$(id -u)" -eq 0 ]; then
  as_root=
elif command -v sudo >/dev/null; then
  as_root=sudo
else
  fail "need root or sudo to install: $missing"
fi

# An environment assignment does not pass through sudo by itself, hence env.
apt() {
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Dpkg::Use-Pty=0 \
    -o Acquire::Retries=3 "$@"
}

echo "packages: installing $missing"
# Package lists are fetched only if those at hand do not serve; $missing is split on purpose.
# shellcheck disable=SC2086
if ! apt install --no-install-recommends -s $missing >/dev/null 2>&1 ||
   ! apt install --no-install-recommends $missing; then
  echo "packages: fetching package lists"
  apt update
  apt install --no-install-recommends $missing ||
    fail "apt-get could not install: $missing"
fi
echo "packages: installed"
