#!/bin/sh
# Prepares OpenFOAM for fsi-driver: finds one (or installs Debian's), builds the adapter for it, checks that it loads.
#
#   of-adapter/setup.sh            for the OpenFOAM that is loaded (its etc/bashrc), or else the newest openfoamNNNN
#                                  below /usr/lib/openfoam, or else Debian's, which is installed if it is missing (as
#                                  root, or as a user with sudo)
#   of-adapter/setup.sh --openfoam WHICH
#                                  for the one in the folder WHICH, or of the number WHICH (2506), or debian
#   of-adapter/setup.sh --list     says which there are and for which of them the adapter is built
#   of-adapter/setup.sh --force    builds again even if nothing changed
#   of-adapter/setup.sh --tests    installs what tests and the book need as well: numpy, a spell checker,
#                                  equations as MathML, a browser for the pages of runs
#   of-adapter/setup.sh --prefix DIR
#                                  installs the library in DIR/lib/fsi-driver/vNNNN/ as well, so that the source tree is
#                                  not needed any more: fsi-driver finds it below its own prefix (~/.cargo for
#                                  `cargo install`), ~/.local and /usr/local, or where FSI_DRIVER_ADAPTER=DIR says
#
# FSI_DRIVER_OPENFOAM=DIR names the folder of an OpenFOAM, or of several openfoamNNNN, for this script and the driver.
#
# In a package's folder (/usr/share/fsi-driver) it works in a copy in the user's cache, and installs below ~/.local, or
# /usr/local as root. Otherwise everything else made here lies in of-adapter/build/. apt's own configuration is read,
# never changed:
#   build/vNNNN/      libfsiAdapter.so and stamp for the OpenFOAM of that number, libfsiStream.so if that needs it, and
#                     check/, the one-step run that proved that the library loads
#   build/apt/        private list of package sources, used only if the machine's own has none for OpenFOAM
#   build/source/     source of Debian's OpenFOAM, exactly the installed version (its packages carry no headers)
set -eu

here=$(cd "$(dirname "$0")" && pwd)
build=$here/build
packages=
debian=/usr/share/openfoam
oldest=1912
tried="1912, v2112, v2312, v2412, v2506, v2606"
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

# Number of the OpenFOAM in a folder, such as 2506; empty if it is none of openfoam.com's.
api_of() {
    if [ "$1" = $debian ]; then
        dpkg-query -W -f '${Version}' openfoam 2>/dev/null | sed -n 's/^\([0-9]\{4\}\)\..*/\1/p'
    else
        sed -n 's/^api=\([0-9]\{4\}\) *$/\1/p' "$1/META-INFO/api-info" 2>/dev/null || : # no such file
    fi
}
# Which build of it: as fsi-driver says it.
version_of() {
    if [ "$1" = $debian ]; then dpkg-query -W -f '${Version}' openfoam
    else echo "$(api_of "$1").$(sed -n 's/^patch=//p' "$1/META-INFO/api-info") in $1"
    fi
}
# All openfoamNNNN in a folder, the newest first.
installed_below() {
    for folder in "$1"/openfoam[0-9][0-9][0-9][0-9]; do [ ! -d "$folder/META-INFO" ] || echo "$folder"; done | sort -r
}

# Sets `project` to the OpenFOAM to build for, `api` and `version` to its number and build, `chosen` to why.
choose() {
    below=/usr/lib/openfoam
    named=${FSI_DRIVER_OPENFOAM:-}
    if [ -n "$named" ] && [ "$named" != $debian ] && [ ! -e "$named/META-INFO" ]; then
        below=$named
        named=
        [ -n "$(installed_below "$below")" ] || foreign "$below"
    fi
    case $wanted in
        debian) project=$debian chosen="Debian's" ;;
        [0-9][0-9][0-9][0-9] | v[0-9][0-9][0-9][0-9])
            project=$below/openfoam${wanted#v} chosen="named by --openfoam"
            [ -d "$project" ] || { [ "$(api_of $debian)" = "${wanted#v}" ] && project=$debian; } ||
                fail "there is no $project; give its folder (--openfoam DIR)" ;;
        ?*) project=$(cd "$wanted" 2>/dev/null && pwd) || fail "--openfoam: there is no folder $wanted"
            chosen="named by --openfoam" ;;
        *)  if [ -n "$named" ]; then project=$named chosen="named by FSI_DRIVER_OPENFOAM"
            elif [ -n "${WM_PROJECT_DIR:-}" ]; then project=$WM_PROJECT_DIR chosen=loaded
            else
                project=$(installed_below "$below" | head -n 1) chosen=installed
                [ -n "$project" ] || project=$debian chosen="Debian's"
            fi ;;
    esac
    if [ "$project" = $debian ]; then
        install_packages openfoam openmpi-bin g++ bzip2 $packages
    elif [ -n "$packages" ]; then
        install_packages $packages
    fi
    api=$(api_of "$project")
    [ -n "$api" ] || foreign "$project"
    version=$(version_of "$project")
    [ "$api" -ge $oldest ] || fail "OpenFOAM $api ($project) is older than $oldest, the oldest that the adapter is for"
    say "using the OpenFOAM that is $chosen: $version"
    made=$build/v$api
}
foreign() {
    for sign in "$1/etc/config.sh/settings" "$1/etc/bashrc"; do
        if [ -f "$sign" ]; then
            fail "$1 is not an OpenFOAM of openfoam.com, which the adapter is for ($tried tried)." \
                "That of openfoam.org has no pimpleFoam that a library could steer (docs/openfoam-versions.md)." \
                "Without leaving it: of-adapter/setup.sh --openfoam debian"
        fi
    done
    fail "there is no OpenFOAM in $1 (no META-INFO/api-info)"
}
list() {
    for folder in ${WM_PROJECT_DIR:-} ${FSI_DRIVER_OPENFOAM:-} $(installed_below /usr/lib/openfoam) $debian; do
        api=$(api_of "$folder")
        [ -n "$api" ] || continue
        adapter="no adapter"
        [ "$(head -n 1 "$build/v$api/stamp" 2>/dev/null)" != "openfoam $(version_of "$folder")" ] || adapter=$build/v$api
        echo "$(version_of "$folder"): $adapter"
    done
}

install_packages() {
    missing=
    for package in "$@"; do installed "$package" || missing="$missing $package"; done
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
        quietly apt-get source --download-only --tar-only "openfoam=$source_version"
    else
        say "fetching the source of openfoam $source_version (45 MB) by a private list of package sources"
        write_private_sources
        quietly private_apt update
        quietly private_apt source --download-only --tar-only "openfoam=$source_version"
    fi
    # Upstream's archive is enough: Debian's patches change how OpenFOAM is compiled, no header.
    mkdir "$source.partial"
    quietly tar -xf openfoam_*.orig.tar.* -C "$source.partial" --strip-components=1 --wildcards '*/src'
    mv "$source.partial" "$source"
    cd "$here"
    rm -rf "$build/source/download"
}

# Sets `includes` to the folders with headers, as seen from the folder of the objects.
find_headers() {
    includes=
    if [ "$project" != $debian ]; then
        for folder in $header_folders; do includes="$includes -isystem $project/src/$folder/lnInclude"; done
        includes="$includes -isystem $project/src/transportModels"
        [ -d "$project/src/OpenFOAM/lnInclude" ] ||
            fail "$project has no headers (src/OpenFOAM/lnInclude): install openfoam$api-dev"
        return 0
    fi
    fetch_source
    rm -rf "$made/include"
    for folder in $header_folders; do
        name=$(echo "$folder" | tr / _)
        flat=$made/include/$name
        mkdir -p "$flat"
        # Template definitions (*.C) are included by headers, hence linked as well.
        find "$source/src/$folder" -type f \( -name '*.H' -o -name '*.C' -o -name '*.h' \) ! -path '*/lnInclude/*' \
            -exec ln -sf -t "$flat" {} +
        includes="$includes -isystem ../include/$name"
    done
    includes="$includes -isystem ../../source/${source##*/}/src/transportModels"
}

# What OpenFOAM's own etc/bashrc sets, in a process of its own; Debian's needs one variable.
with_openfoam() {
    if [ "$project" = $debian ]; then
        env WM_PROJECT_DIR=$debian "$@"
    elif [ "${WM_PROJECT_DIR:-}" = "$project" ]; then
        "$@"
    else
        bash -c '. "$0/etc/bashrc" >/dev/null 2>&1; exec "$@"' "$project" "$@"
    fi
}

compile() {
    # From within the folder of the objects, by relative paths: the project's folder may have a blank in its name.
    find_headers
    libraries=
    for library in $link_libraries; do libraries="$libraries -l$library"; done
    say "compiling the adapter"
    if [ "$api" -ge 2412 ]; then standard=c++17; elif [ "$api" -ge 2212 ]; then standard=c++14; else standard=c++11; fi
    # shellcheck disable=SC2016
    sizes=$(with_openfoam sh -c 'echo "${WM_PRECISION_OPTION:-DP} ${WM_LABEL_SIZE:-32}"')
    [ "${sizes% *}" = DP ] || fail "$project is of single precision (${sizes% *}); the adapter needs DP"
    # WM_DP, WM_LABEL_SIZE: scalars and labels as OpenFOAM was built. Its headers would warn, hence -isystem.
    flags="-std=$standard -DOPENFOAM=$api -DWM_DP -DWM_LABEL_SIZE=${sizes#* } -DNoRepository
        -ftemplate-depth-100 -O2 -fPIC -Wall -Wextra $includes"
    rm -rf "$made/objects" "$made/libfsiStream.so"
    mkdir -p "$made/objects"
    cd "$made/objects"
    quietly sh -c 'ls ../../../src/*.C | xargs -P "$(nproc)" -n 1 g++ -c $1' compile "$(echo $flags)"
    # shellcheck disable=SC2016,SC2086
    quietly with_openfoam sh -c 'library=$1; shift; g++ -shared ./*.o -o "$library" ${FOAM_LIBBIN:+"-L$FOAM_LIBBIN"} "$@"' \
        link "$made/libfsiAdapter.so.partial" $libraries
    cd "$here"
    mv "$made/libfsiAdapter.so.partial" "$made/libfsiAdapter.so"
}

# One time step of pimpleFoam with the library loaded and its windkessel at the outlet, on a rigid channel, no driver.
check_run() {
    check=$made/check
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
	libs ("$made/libfsiAdapter.so"); fsiStartTime 0; fsiTransport none; fsiAddress none; fsiDriver 0;
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
    # A function object that does nothing: that one is read at all is part of the check
    echo 'endTime 0.002; #remove functions
        functions { none { type none; enabled no; } }' >>"$check/system/controlDict"
    echo 'dynamicFvMesh staticFvMesh;' >>"$check/constant/dynamicMeshDict"
    cd "$check"
    case $build in *' '*) # or OpenFOAM removes the blank
        FOAM_CONTROLDICT=$(cat "$project/etc/controlDict"; echo 'InfoSwitches { allowSpaceInFileName 1; }')
        export FOAM_CONTROLDICT ;;
    esac
    quietly with_openfoam blockMesh
    if ! with_openfoam pimpleFoam >"$build/last-command.log" 2>&1; then
        if grep -q 'IOstream "sha1"' "$build/last-command.log"; then
            say "this OpenFOAM reads no function objects; libfsiStream.so mends that (of-adapter/check/ostreamPut.cc)"
            quietly g++ -O2 -fPIC -shared "$here/check/ostreamPut.cc" -o "$made/libfsiStream.so"
            # By its name: a path in LD_PRELOAD must not have a blank.
            # shellcheck disable=SC2016
            quietly with_openfoam sh -c 'LD_PRELOAD=libfsiStream.so LD_LIBRARY_PATH=$0:${LD_LIBRARY_PATH:-} exec pimpleFoam' "$made"
        else
            quietly with_openfoam pimpleFoam
        fi
    fi
    grep -qx End "$build/last-command.log" ||
        fail "the one-step run with the adapter did not end as it should; see $build/last-command.log"
    cd "$here"
}

# What the library depends on: the installed OpenFOAM, the adapter's sources, and how they are built.
stamp() {
    echo "openfoam $version"
    echo "adapter $(cat "$here"/setup.sh "$here"/src/* "$here"/check/* | sha256sum | cut -d' ' -f1)"
}

# Copies the library and its stamp below the prefix, if one was given; a run that uses the old one keeps it.
install_library() {
    [ -n "$prefix" ] || return 0
    folder=$prefix/lib/fsi-driver/v$api
    if cmp -s "$made/libfsiAdapter.so" "$folder/libfsiAdapter.so" && cmp -s "$made/stamp" "$folder/stamp"; then
        say "nothing to do: $folder/libfsiAdapter.so is the same"
        return 0
    fi
    mkdir -p "$folder" || fail "cannot make $folder: choose another --prefix, or run as root"
    rm -f "$folder/libfsiStream.so"
    for file in libfsiAdapter.so libfsiStream.so stamp; do
        [ -f "$made/$file" ] || continue
        cp "$made/$file" "$folder/$file.partial" && mv "$folder/$file.partial" "$folder/$file" ||
            fail "cannot write $folder/$file: choose another --prefix, or run as root"
    done
    say "installed: $folder/libfsiAdapter.so"
}

usage="the options are --openfoam DIR|NUMBER|debian, --list, --force, --tests and --prefix DIR"
force=
prefix=
wanted=
while [ $# -gt 0 ]; do
    case $1 in
        --force) force=yes ;;
        --list) list; exit 0 ;;
        --tests) packages="$packages python3-numpy python3-venv codespell blahtexml chromium" ;;
        --openfoam=*) wanted=${1#--openfoam=}; [ -n "$wanted" ] || fail "--openfoam needs a folder; $usage" ;;
        --openfoam) [ -n "${2:-}" ] || fail "--openfoam needs a folder; $usage"; wanted=$2; shift ;;
        --prefix=*) prefix=${1#--prefix=}; [ -n "$prefix" ] || fail "--prefix needs a folder; $usage" ;;
        --prefix) [ -n "${2:-}" ] || fail "--prefix needs a folder; $usage"; prefix=$2; shift ;;
        *) fail "unknown option '$1'; $usage" ;;
    esac
    shift
done
case $prefix in '' | /*) ;; *) prefix=$PWD/$prefix ;; esac
# From a package: below /usr/share nothing is built, but in a copy, from which the library is installed.
copy=${XDG_CACHE_HOME:-$HOME/.cache}/fsi-driver/of-adapter
if [ "$here" != "$copy/of-adapter" ] && { [ ! -w "$here" ] || [ "${here#/usr/}" != "$here" ]; }; then
    mkdir -p "$copy/openfoam-case"
    rm -rf "$copy/of-adapter/src" "$copy/of-adapter/check" "$copy/openfoam-case/base"
    mkdir -p "$copy/of-adapter"
    cp -r "$here/setup.sh" "$here/src" "$here/check" "$copy/of-adapter/"
    cp -r "$here/../openfoam-case/base" "$copy/openfoam-case/"
    if [ -z "$prefix" ]; then prefix=$HOME/.local; [ "$(id -u)" -ne 0 ] || prefix=/usr/local; fi
    exec "$copy/of-adapter/setup.sh" ${wanted:+--openfoam "$wanted"} ${force:+--force} --prefix "$prefix"
fi
mkdir -p "$build"
exec 9>"$build/lock" # a second setup.sh at the same time waits, and then finds nothing to do
flock 9
choose
mkdir -p "$made"
[ -z "$force" ] || rm -f "$made/stamp"
if [ "$(stamp)" = "$(cat "$made/stamp" 2>/dev/null)" ] && [ -f "$made/libfsiAdapter.so" ]; then
    say "nothing to do: $made/libfsiAdapter.so is built for $(head -n 1 "$made/stamp")"
    install_library
    exit 0
fi
rm -f "$made/stamp"
compile
say "checking it in one time step of pimpleFoam"
check_run
stamp >"$made/stamp"
say "done: $made/libfsiAdapter.so, built for $(head -n 1 "$made/stamp") and found to load"
install_library
