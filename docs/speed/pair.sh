#!/bin/bash
# Two commits side by side: docs/speed/pair.sh FOLDER OLD NEW [OPTION...]
#
# Builds both in FOLDER, once, and runs the plain command with each in turn: old, new, new, old and so on. Prints
# NEW/OLD, the median of the pairs with the least and the largest: seconds of a step, of the run, and of the processors
# (driver and OpenFOAM together). OPTIONs are those of fsi-driver; without them: --case openfoam-case/S-0.25 --preset
# coarse --fluid native. Each commit takes the case from its own tree. From the environment:
#
#   END=0.08   end of the runs, s: the first 40 steps; END=1 is a whole beat
#   PAIRS=3    number of pairs
#
# A busy machine changes seconds by a factor of two within minutes, but both runs of a pair alike, and the seconds of
# the processors less. A ratio whose range contains 1 says nothing. What the machine could do before and after is said.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 2; }
out=$(mkdir -p "$1" && cd "$1" && pwd)
cd "$(dirname "$0")/../.."
old=$(git rev-parse --short "$2^{commit}") new=$(git rev-parse --short "$3^{commit}")
shift 3
[ $# -gt 0 ] || set -- --case openfoam-case/S-0.25 --preset coarse --fluid native
end=${END:-0.08} pairs=${PAIRS:-3}

for commit in "$old" "$new"; do
    tree=$out/$commit
    [ ! -x "$tree/fsi-driver" ] || continue
    mkdir -p "$tree"
    git archive "$commit" | tar -x -C "$tree"
    case " $* " in *" native "*) ;; *) "$tree/of-adapter/setup.sh" ;; esac
    # Dependencies are compiled once for both.
    (cd "$tree" && CARGO_TARGET_DIR=$out/target cargo build --release --quiet)
    cp "$out/target/release/fsi-driver" "$tree/fsi-driver"
done

# run COMMIT OPTIONS...: its figures, a line each: name and seconds
run() {
    tree=$out/$1
    shift
    rm -rf "$out/run"
    TIMEFORMAT='%U %S'
    { time (cd "$tree" && ./fsi-driver "$@" --quiet --end-time "$end" --out "$out/run" > "$out/run.log" 2>&1); } 2> "$out/time" ||
        { cat "$out/run.log" "$out/time" >&2; exit 1; }
    # The median of a column that was sorted.
    for part in 'all steps, median:1' 'first 40 steps, median:$1 <= 0.0801' 't > 0.4 s, median:$1 > 0.4'; do
        awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next } '"${part#*:}"' { print $at["wall_s"] }' "$out/run/history.csv" |
            sort -g | awk -v name="${part%:*}" '{ value[NR] = $1 } END { if (NR) print name "\t" value[int((NR + 1) / 2)] }'
    done
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
        { wall += $at["wall_s"]; fluid += $at["fluid_s"]; structure += $at["structure_s"] }
        END { print "all steps, sum\t" wall; print "of it fluid\t" fluid; print "of it structure\t" structure }' "$out/run/history.csv"
    awk '{ print "processors, with the start\t" $1 + $2 }' "$out/time"
}

yardstick() {
    [ ! -f "$out/$new/benches/yardstick.rs" ] ||
        (cd "$out/$new" && CARGO_TARGET_DIR=$out/target cargo bench --quiet --bench yardstick)
}

yardstick
: > "$out/figures"
for ((pair = 1; pair <= pairs; pair++)); do
    order=("$old" "$new")
    [ $((pair % 2)) -eq 1 ] || order=("$new" "$old")
    for commit in "${order[@]}"; do
        run "$commit" "$@" | sed "s/^/$pair\t$commit\t/" | tee -a "$out/figures" >&2
    done
done

yardstick
echo "$new/$old, $pairs pairs to t = $end s: $*"
awk -F'\t' -v old="$old" -v new="$new" '
    !($3 in seen) { seen[$3] = ++count; name[count] = $3 }
    { value[$1, $2, $3] = $4; if ($1 > pairs) pairs = $1 }
    function middle(list, n,   i, j, swap) {
        for (i = 2; i <= n; i++) for (j = i; j > 1 && list[j - 1] > list[j]; j--) { swap = list[j]; list[j] = list[j - 1]; list[j - 1] = swap }
        return n % 2 ? list[(n + 1) / 2] : (list[n / 2] + list[n / 2 + 1]) / 2
    }
    END {
        printf "%-28s %10s %10s %8s\n", "seconds", "old", "new", "ratio"
        for (k = 1; k <= count; k++) {
            for (p = 1; p <= pairs; p++) {
                a[p] = value[p, old, name[k]]; b[p] = value[p, new, name[k]]; r[p] = a[p] ? b[p] / a[p] : 0
            }
            ratio = middle(r, pairs)
            printf "%-28s %10.3f %10.3f %8.2f (%.2f to %.2f)\n", name[k], middle(a, pairs), middle(b, pairs), ratio, r[1], r[pairs]
        }
    }' "$out/figures"
