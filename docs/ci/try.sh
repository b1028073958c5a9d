#!/bin/sh
# Runs the container's recipe without a container: docs/ci/try.sh DIR makes a plain Debian 12 in DIR (debootstrap, as
# root) and runs the RUN lines of Containerfile in it, one by one. SUITE=trixie makes a Debian 13. RUST=DIR (a folder
# with .cargo and .rustup, such as $HOME) uses that toolchain instead of downloading one with rustup.
set -eu
[ $# = 1 ] || { echo "usage: docs/ci/try.sh DIR" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
project=$(cd "$here/../.." && pwd)
mkdir -p "$1"
root=$(cd "$1" && pwd)
[ -x "$root/bin/sh" ] || debootstrap --variant=minbase "${SUITE:-bookworm}" "$root"

mounted=
leave() { for folder in $mounted; do umount "$root/$folder"; done; }
trap leave EXIT
trap 'exit 130' INT TERM
share() {
    mkdir -p "$root/$2"
    mount --bind "$1" "$root/$2"
    mounted="$2 $mounted"
}
share /proc proc
share /dev dev
if [ -n "${RUST:-}" ]; then
    share "$RUST/.cargo" root/.cargo
    share "$RUST/.rustup" root/.rustup
fi
cp /etc/resolv.conf "$root/etc/resolv.conf"

mkdir -p "$root/opt/fsi-driver"
tar -C "$project" --exclude=./.git --exclude=./target --exclude=./of-adapter/build -cf - . | tar -C "$root/opt/fsi-driver" -xf -

# One line a RUN: continued lines joined.
commands=$(sed -e :a -e '/\\$/N; s/\\\n//; ta' "$here/Containerfile" | sed -n 's/^RUN //p')
path=$(sed -n 's/^ENV PATH=//p' "$here/Containerfile")
echo "$commands" | while read -r line; do
    case $line in *rustup*) [ -z "${RUST:-}" ] || continue ;; esac
    echo "+ $line"
    chroot "$root" /usr/bin/env -i HOME=/root "PATH=$path" /bin/sh -c "cd /opt/fsi-driver && $line" </dev/null
done
echo "The recipe works."
