#!/bin/sh
# Makes what users install into dist/, with SHA-256 sums: docs/dist/make.sh [wheel] [deb] [crate], all without a word.
# Nothing is uploaded. Needs cargo; for the wheel python3 with venv (maturin comes from PyPI), for the package dpkg-deb.
set -eu
cd "$(dirname "$0")/../.."
root=$PWD
dist=$root/dist
work=$root/target/dist
mkdir -p "$dist" "$work"
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)
say() { printf '%s\n' "make: $*"; }

wheel() {
    python=${PYTHON:-python3}
    [ -x "$work/venv/bin/maturin" ] || {
        "$python" -m venv --clear "$work/venv"
        "$work/venv/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.7,<2'
    }
    rm -f "$dist"/fsi_driver-*.whl
    (cd src/python && "$work/venv/bin/maturin" build --quiet --release --locked --target-dir "$root/target" --out "$dist")
    say "$(ls "$dist"/fsi_driver-*.whl)"
}

# Program, manual, completions, the adapter's sources with what their check needs, and a hint after installation.
deb() {
    cargo build --release --locked --quiet
    program=target/release/fsi-driver
    tree=$work/deb
    rm -rf "$tree"
    mkdir -p "$tree/DEBIAN" "$tree/usr/bin" "$tree/usr/share/man/man1" "$tree/usr/share/doc/fsi-driver" \
        "$tree/usr/share/bash-completion/completions" "$tree/usr/share/zsh/vendor-completions" \
        "$tree/usr/share/fish/vendor_completions.d" "$tree/usr/share/fsi-driver/of-adapter" \
        "$tree/usr/share/fsi-driver/openfoam-case"
    install -s "$program" "$tree/usr/bin/"
    "$program" man "$tree/usr/share/man/man1" >/dev/null
    gzip -9n "$tree"/usr/share/man/man1/*
    "$program" completions bash >"$tree/usr/share/bash-completion/completions/fsi-driver"
    "$program" completions zsh >"$tree/usr/share/zsh/vendor-completions/_fsi-driver"
    "$program" completions fish >"$tree/usr/share/fish/vendor_completions.d/fsi-driver.fish"
    cp -r of-adapter/setup.sh of-adapter/src of-adapter/check of-adapter/PROTOCOL.md "$tree/usr/share/fsi-driver/of-adapter/"
    cp -r openfoam-case/base "$tree/usr/share/fsi-driver/openfoam-case/"
    cp LICENSE "$tree/usr/share/doc/fsi-driver/copyright"
    gzip -9nc CHANGELOG.md >"$tree/usr/share/doc/fsi-driver/changelog.gz"
    # The C library that it was linked with is the oldest that it runs on.
    libc=$(dpkg-query -W -f '${Version}' libc6 | sed 's/-.*//')
    cat >"$tree/DEBIAN/control" <<-END_OF_CONTROL
	Package: fsi-driver
	Version: $version
	Architecture: $(dpkg --print-architecture)
	Maintainer: the authors of fsi-driver <fsi-driver@localhost>
	Section: science
	Priority: optional
	Installed-Size: $(du -sk "$tree/usr" | cut -f1)
	Depends: libc6 (>= $libc), libgcc-s1
	Suggests: openfoam, openmpi-bin, g++, bzip2, paraview
	Description: fluid-structure interaction of arteries
	 p-version finite elements for the wall, OpenFOAM or spectral elements for the
	 blood.
	END_OF_CONTROL
    cat >"$tree/DEBIAN/postinst" <<-'END_OF_HINT'
	#!/bin/sh
	set -e
	[ "$1" != configure ] || cat <<'END_OF_TEXT'
	fsi-driver: the native fluid is ready: fsi-driver new my-case && fsi-driver --case my-case --preset demo --fluid native
	For OpenFOAM build the adapter once: /usr/share/fsi-driver/of-adapter/setup.sh
	END_OF_TEXT
	END_OF_HINT
    chmod 755 "$tree/DEBIAN/postinst"
    dpkg-deb --root-owner-group --build "$tree" "$dist" >/dev/null
    say "$(ls "$dist"/fsi-driver_*.deb)"
}

# Packages for crates.io, those that the program depends on first.
crate() {
    cargo package --workspace --no-verify --allow-dirty --quiet
    cp target/package/*-"$version".crate "$dist/"
    say "$(ls "$dist"/*.crate | tr '\n' ' ')"
}

[ $# -gt 0 ] || set -- wheel deb crate
for what in "$@"; do
    case $what in
        wheel | deb | crate) $what ;;
        *) echo "make: unknown '$what'; there are wheel, deb and crate" >&2; exit 2 ;;
    esac
done
(cd "$dist" && sha256sum -- *.whl *.deb *.crate 2>/dev/null >SHA256SUMS || true)
cat "$dist/SHA256SUMS"
