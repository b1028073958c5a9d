#!/bin/sh
# Prepares OpenFOAM for fsi-driver on Debian 12: installs what is missing, builds the adapter, checks that it loads.
#
#   of-adapter/setup.sh            as root, or as a user with sudo (only asked for if a package is missing)
#   of-adapter/setup.sh --force    builds again even if nothing changed
#   of-adapter/setup.sh --tests    installs what tests and the book need as well: numpy, a spell checker,
#                                  equations as MathML, a browser for the pages of runs
#   of-adapter/setup.sh --prefix DIR
#                                  installs the library in DIR/lib/fsi-driver/ as well, so that the source tree is not
#                                  needed any more: fsi-driver finds it below its own prefix (~/.cargo for
#                                  `cargo install`), ~/.local and /usr/local, or where FSI_DRIVER_ADAPTER=DIR says
#
# Everything else made here lies in of-adapter/build/; apt's own configuration is read, never changed:
#   build/apt/        private list of package sources, used only if the machine's own has none for OpenFOAM
#   build/source/     OpenFOAM's source, exactly the installed version (the binary packages carry no headers)
#   build/include/    links to its headers, one flat folder per library
#   build/check/      the one-step run that proved the library loads
#   build/libfsiAdapter.so, build/stamp
set -eu

here=$(cd "$(dirname "$0")" && pwd)
build=$here/build
packages="openfoam openmpi-bin g++ dpkg-dev"
# Libraries whose headers the adapter includes, and libraries it is linked to.
header_folders="OpenFOAM OSspecific/POSIX finiteVolume meshTools dynamicMesh dynamicFvMesh
    TurbulenceModels/turbulenceModels TurbulenceModels/incompressible"
link_libraries="dynamicMesh dynamicFvMesh incompressibleTurbulenceModels turbulenceModels
    incompressibleTransportModels finiteVolume meshTools OpenFOAM"

say() { printf '%s\n' "setup: $*"; }
fail() { printf '%s\n' "setup: error: $*" >&2; exit 1; }
quietly() { # runs a command, shows its output only if it fails
    if ! "$@" >"$build/last-command.log" 2>&1; then
        tail -n 30 "$build/last-command.log" >&2
        fail "'$*' failed; its whole output is in $build/last-command.log"
    fi
}
as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"
    elif command -v sudo >/dev/null; then sudo "$@"
    else fail "not root and no sudo here; run as root: $*"
    fi
}
installed() { dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null | grep -qx installed; }

install_packages() {
    missing=
    for package in $packages; do installed "$package" || missing="$missing $package"; done
    [ -n "$missing" ] || return 0
    say "installing$missing (needs root)"
    quietly as_root apt-get update
    # shellcheck disable=SC2086  # the list is meant to be split
    quietly as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends $missing
}

# apt with package sources for the archive that OpenFOAM came from, from a configuration of our own.
private_apt() {
    apt-get -o "Dir::Etc::sourcelist=$build/apt/sources.list" -o Dir::Etc::sourceparts=/dev/null \
        -o "Dir::State::lists=$build/apt/lists" -o "Dir::Cache=$build/apt/cache" -o APT::Sandbox::User="$(id -un)" "$@"
}
write_private_sources() {
    # madison: "openfoam | 1912.200626-1+b1 | <archive> bookworm/main amd64 Packages",
    # whichever format (one-line .list or deb822 .sources) the machine's own entries have.
    archive=$(apt-cache madison openfoam | awk -F' [|] ' '/Packages$/ { print $3; exit }')
    if [ -z "$archive" ]; then # a machine whose package lists were cleaned away
        quietly as_root apt-get update
        archive=$(apt-cache madison openfoam | awk -F' [|] ' '/Packages$/ { print $3; exit }')
    fi
    [ -n "$archive" ] || fail "apt knows no archive that offers 'openfoam'; add a Debian 12 mirror to /etc/apt and run 'apt-get update'"
    # shellcheck disable=SC2086
    set -- $archive
    keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    options=; [ ! -r $keyring ] || options="[signed-by=$keyring] "
    mkdir -p "$build/apt/lists/partial" "$build/apt/cache/archives/partial"
    echo "deb-src $options$1 ${2%%/*} ${2#*/}" >"$build/apt/sources.list"
}

fetch_source() {
    source_version=$(dpkg-query -W -f '${source:Version}' openfoam)
    source=$build/source/openfoam-$source_version
    [ ! -d "$source/src" ] || return 0
    rm -rf "$build/source"
    mkdir -p "$build/source/download"
    cd "$build/source/download"
    if apt-get source --print-uris "openfoam=$source_version" >/dev/null 2>&1; then
        say "fetching the source of openfoam $source_version (45 MB)"
        quietly apt-get source --download-only "openfoam=$source_version"
    else
        say "fetching the source of openfoam $source_version (45 MB) by a private list of package sources"
        write_private_sources
        quietly private_apt update
        quietly private_apt source --download-only "openfoam=$source_version"
    fi
    quietly dpkg-source --no-check --no-copy -x openfoam_*.dsc "$source.partial"
    mv "$source.partial" "$source"
    cd "$here"
    rm -rf "$build/source/download"
}

link_headers() {
    rm -rf "$build/include"
    for folder in $header_folders; do
        flat=$build/include/$(echo "$folder" | tr / _)
        mkdir -p "$flat"
        # Template definitions (*.C) are included by headers, hence linked as well.
        find "$source/src/$folder" -type f \( -name '*.H' -o -name '*.C' -o -name '*.h' \) ! -path '*/lnInclude/*' \
            -exec ln -sf -t "$flat" {} +
    done
}

compile() {
    # From within build/objects, by relative paths: the project's folder may have a blank in its name.
    includes=
    for folder in $header_folders; do includes="$includes -isystem ../include/$(echo "$folder" | tr / _)"; done
    libraries=
    for library in $link_libraries; do libraries="$libraries -l$library"; done
    say "compiling the adapter"
    # WM_DP, WM_LABEL_SIZE: scalars and labels as in Debian's build. OpenFOAM's headers would warn, hence -isystem.
    flags="-std=c++11 -DOPENFOAM=${source_version%%.*} -DWM_DP -DWM_LABEL_SIZE=32 -DNoRepository -ftemplate-depth-100
        -O2 -fPIC -Wall -Wextra $includes -isystem ../source/${source##*/}/src/transportModels"
    rm -rf "$build/objects"
    mkdir -p "$build/objects"
    cd "$build/objects"
    quietly sh -c 'ls ../../src/*.C | xargs -P "$(nproc)" -n 1 g++ -c $1' compile "$(echo $flags)"
    # shellcheck disable=SC2086
    quietly g++ -shared ./*.o -o "$build/libfsiAdapter.so.partial" $libraries
    cd "$here"
    mv "$build/libfsiAdapter.so.partial" "$build/libfsiAdapter.so"
}

# One time step of pimpleFoam with the library loaded and its windkessel at the outlet, on a rigid channel, no driver.
check_run() {
    check=$build/check
    rm -rf "$check"
    cp -r "$here/../openfoam-case/base" "$check"
    cp "$here/check/blockMeshDict" "$check/system/"
    cat >"$check/system/fsiParameters" <<-END
	density 1050; kinematicViscosity 3.3e-6; timeStep 0.002; rampDuration 0.01; ranks 1;
	initialPressure 0; meshMotion referenceLaplacian; transportModel Newtonian; openings (inlet outlet); wetPatches (wallFsi);
	normalGradient corrected; nonOrthogonalCorrectors 0; consistentPressure no; timeDerivative Euler;
	convectionScheme linearUpwind grad(U);
	END
    cat >"$check/system/fsiConnection" <<-END
	libs ("$build/libfsiAdapter.so"); fsiStartTime 0; fsiTransport none; fsiAddress none; fsiDriver 0;
	END
    mkdir "$check/system/fsiOpenings"
    cat >"$check/system/fsiOpenings/p" <<-END
	inlet { type zeroGradient; }
	outlet { type windkesselPressure; resistance 2.85e9; compliance 1.2e-10; pressure 11000; density 1050; }
	END
    cat >"$check/system/fsiOpenings/U" <<-END
	inlet { type flowRateInletVelocity; volumetricFlowRate 3e-6; value uniform (0 0 0); }
	outlet { type inletOutlet; inletValue uniform (0 0 0); value uniform (0 0 0); }
	END
    echo '"(inlet|outlet)" { type fixedValue; value uniform (0 0 0); }' >"$check/system/fsiOpenings/pointDisplacement"
    echo 'endTime 0.002; #remove functions' >>"$check/system/controlDict"
    echo 'dynamicFvMesh staticFvMesh;' >>"$check/constant/dynamicMeshDict"
    cd "$check"
    WM_PROJECT_DIR=/usr/share/openfoam
    export WM_PROJECT_DIR
    case $build in *' '*) # or OpenFOAM removes the blank
        FOAM_CONTROLDICT=$(cat "$WM_PROJECT_DIR/etc/controlDict"; echo 'InfoSwitches { allowSpaceInFileName 1; }')
        export FOAM_CONTROLDICT ;;
    esac
    quietly blockMesh
    quietly pimpleFoam
    grep -qx End "$build/last-command.log" ||
        fail "the one-step run with the adapter did not end as it should; see $build/last-command.log"
    cd "$here"
}

# What the library depends on: the installed OpenFOAM, the adapter's sources, and how they are built.
stamp() {
    echo "openfoam $(dpkg-query -W -f '${Version}' openfoam)"
    echo "adapter $(cat "$here"/setup.sh "$here"/src/* | sha256sum | cut -d' ' -f1)"
}

# Copies the library and its stamp below the prefix, if one was given; a run that uses the old one keeps it.
install_library() {
    [ -n "$prefix" ] || return 0
    folder=$prefix/lib/fsi-driver
    if cmp -s "$build/libfsiAdapter.so" "$folder/libfsiAdapter.so" && cmp -s "$build/stamp" "$folder/stamp"; then
        say "nothing to do: $folder/libfsiAdapter.so is the same"
        return 0
    fi
    mkdir -p "$folder" || fail "cannot make $folder: choose another --prefix, or run as root"
    for file in libfsiAdapter.so stamp; do
        cp "$build/$file" "$folder/$file.partial" && mv "$folder/$file.partial" "$folder/$file" ||
            fail "cannot write $folder/$file: choose another --prefix, or run as root"
    done
    say "installed: $folder/libfsiAdapter.so"
}

usage="the options are --force, --tests and --prefix DIR"
force=
prefix=
while [ $# -gt 0 ]; do
    case $1 in
        --force) force=yes ;;
        --tests) packages="$packages python3-numpy codespell blahtexml chromium" ;;
        --prefix=*) prefix=${1#--prefix=}; [ -n "$prefix" ] || fail "--prefix needs a folder; $usage" ;;
        --prefix) [ -n "${2:-}" ] || fail "--prefix needs a folder; $usage"; prefix=$2; shift ;;
        *) fail "unknown option '$1'; $usage" ;;
    esac
    shift
done
case $prefix in '' | /*) ;; *) prefix=$PWD/$prefix ;; esac
mkdir -p "$build"
exec 9>"$build/lock" # a second setup.sh at the same time waits, and then finds nothing to do
flock 9
[ -z "$force" ] || rm -f "$build/stamp"
install_packages
if [ "$(stamp)" = "$(cat "$build/stamp" 2>/dev/null)" ] && [ -f "$build/libfsiAdapter.so" ]; then
    say "nothing to do: $build/libfsiAdapter.so is built for $(head -n 1 "$build/stamp")"
    install_library
    exit 0
fi
rm -f "$build/stamp"
fetch_source
link_headers
compile
say "checking it in one time step of pimpleFoam"
check_run
stamp >"$build/stamp"
say "done: $build/libfsiAdapter.so, built for $(head -n 1 "$build/stamp") and found to load"
install_library
