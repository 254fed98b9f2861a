#!/bin/sh
# Proves that the two commands need nothing but a bare Debian 12: makes one with debootstrap, copies the
# last commit of this tree into it and runs the commands there as root; then the same in a second
# bare Debian as a user with sudo.
#
#   deploy/prove_clean_root.sh FOLDER                # the demo and tests/run.sh --quick
#   deploy/prove_clean_root.sh FOLDER --whole-suite  # as root the whole of tests/run.sh
#
# Needs root, debootstrap and 15 GB in FOLDER, which is kept for a look, with the logs. MIRROR names a
# Debian mirror. Certificates in /usr/local/share/ca-certificates are taken along, for networks that
# look into TLS. The two roots share a compiler cache, nothing else.
set -eu

fail() {
  echo "prove_clean_root: $*" >&2
  exit 1
}

[ $# -ge 1 ] || fail "name a folder"
[ "$(id -u)" -eq 0 ] || fail "need root, for debootstrap and chroot"
command -v debootstrap >/dev/null || fail "need debootstrap: apt-get install debootstrap"

# In a mount namespace of its own, so that every mount ends with this script.
[ -n "${PENUMBRA_IN_NAMESPACE-}" ] ||
  PENUMBRA_IN_NAMESPACE=1 exec unshare --mount --propagation private "$0" "$@"

suite="tests/run.sh --quick"
[ "${2-}" != --whole-suite ] || suite="tests/run.sh"
mirror=${MIRROR:-http://deb.debian.org/debian}
tree=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1/ccache"
folder=$(cd "$1" && pwd)
chmod 1777 "$folder/ccache"

step() { printf '\n== %s\n' "$*"; }

make_base() {
  [ ! -e "$folder/base/etc/debian_version" ] || return 0
  step "debootstrap"
  debootstrap --variant=minbase bookworm "$folder/base.new" "$mirror" > "$folder/debootstrap.log"
  for suite_name in bookworm bookworm-updates; do
    echo "deb $mirror $suite_name main"
  done > "$folder/base.new/etc/apt/sources.list"
  mv "$folder/base.new" "$folder/base"
}

# A bare Debian with the tree in /penumbra.
make_root() {
  root=$folder/$1
  rm -rf --one-file-system "$root"
  cp -a "$folder/base" "$root"
  mkdir -p "$root/penumbra" "$root/ccache" "$root/usr/local/share/ca-certificates"
  git -C "$tree" archive HEAD | tar -C "$root/penumbra" -x --no-same-owner
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  cp /usr/local/share/ca-certificates/*.crt "$root/usr/local/share/ca-certificates/" 2>/dev/null || true
  mount -t proc proc "$root/proc"
  mount -t tmpfs tmpfs "$root/dev/shm"
  mount --bind "$folder/ccache" "$root/ccache"
}

# Runs COMMAND as USER in the tree of $root, logs it and says how long it took.
run_as() {
  user=$1
  shift
  step "as $user in $root: $*"
  log=$folder/$(basename "$root")-$(echo "$*" | tr -c 'a-z0-9\n' '-').log
  began=$(date +%s)
  status=0
  chroot "$root" su - "$user" -c "cd /penumbra && CCACHE_DIR=/ccache CCACHE_UMASK=000 $*" \
    > "$log" 2>&1 || status=$?
  tail -n 20 "$log"
  echo "status $status after $(($(date +%s) - began)) s, log in $log"
  [ "$status" -eq 0 ] || fail "'$*' as $user failed"
}

make_base
echo "commit $(git -C "$tree" rev-parse HEAD)"

make_root root
run_as root deploy/demo.sh
run_as root "$suite"
run_as root deploy/demo.sh

make_root sudo
chroot "$root" sh -c 'apt-get -q update && apt-get -q -y install sudo && rm -rf /var/lib/apt/lists/* &&
  useradd -m builder && echo "builder ALL=(ALL) NOPASSWD: ALL" > /etc/sudoers.d/builder &&
  chown -R builder /penumbra' > "$folder/sudo-setup.log" 2>&1
run_as builder deploy/demo.sh
run_as builder tests/run.sh --quick

step "both commands work in a bare Debian 12, as root and with sudo"
