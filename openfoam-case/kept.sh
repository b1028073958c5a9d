# How the scripts begin that compare a case with measured or published data, and what they share. A script that reads
# this says what it does unless it is called with one folder: $out. It goes on in the project's folder, with that of its
# own case in $case.

[ $# -eq 1 ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 2; }
out=$(mkdir -p "$1" && cd "$1" && pwd)
cd "$(dirname "$0")"
case=$PWD
while [ ! -f Cargo.lock ]; do cd ..; done
case=${case#"$PWD/"}

fsi() { cargo run --release --quiet -- "$@"; }

is_complete() { grep -qs '"status": "complete"' "$1/summary.json"; }

# complete RUN OPTIONS...: computes it, or goes on where it ended
complete() {
    run=$1
    shift
    is_complete "$run" && return
    resume=
    [ ! -d "$run/checkpoints" ] || resume=--resume
    fsi --out "$run" $resume "$@"
}

# keep RUN KEPT: its settings, without the path to this machine's copy of the case, and its figures
keep() {
    mkdir -p "$2"
    sed "s|$PWD/$case/||" "$1/case.resolved.toml" >"$2/case.resolved.toml"
    cp "$1/summary.json" "$1/hemodynamics.json" "$2"
}

# complete_and_keep NAME OPTIONS...: the run FOLDER/NAME, now $run, with what keep copies in kept/NAME, now $kept
complete_and_keep() {
    kept=$case/kept/$1 name=$1
    shift
    complete "$out/$name" "$@"
    keep "$run" "$kept"
}

# keep_last RUN KEPT: the last step of what it recorded at points
keep_last() {
    for table in probes.csv fluid-probes.csv; do
        last=$(tail -n 1 "$1/$table" | cut -d, -f1)
        awk -F, -v last="$last" 'NR == 1 || $1 == last' "$1/$table" >"$2/$table"
    done
}
