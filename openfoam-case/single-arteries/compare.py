"""Compares the last beat of a run with the published curves at mid-length, or with another run:

    python3 compare.py RUN carotid|aorta [OTHER]

Prints a table in Markdown. Root mean squares over the beat, and differences of the largest values, are shares of the
largest published (or the other run's) value.
"""

import csv
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).parent
PERIOD = {"carotid": 1.1, "aorta": 0.955}
# By how much later than the inflow the published curves in three dimensions start.
LATER = {("carotid", "3d"): -0.056}


def rows(path, keys):
    """Columns of a table as lists; rows that lack a value are left out."""
    with open(path, encoding="utf-8") as file:
        table = csv.DictReader(line for line in file if not line.startswith("#"))
        found = [row for row in table if all(row[key] for key in keys)]
    return [[float(row[key]) for row in found] for key in keys]


def at(t, times, values, period):
    """Linear interpolation in a periodic curve."""
    t = (t - times[0]) % period + times[0]
    pairs = list(zip(times, values)) + [(times[0] + period, values[0])]
    for (a, x), (b, y) in zip(pairs, pairs[1:]):
        if a <= t <= b:
            return x + (y - x) * (t - a) / (b - a)
    raise ValueError(t)


def computed(run, period):
    """Times of the last whole beat, and the four quantities as in the published files."""
    time, p_in, p_out = rows(run / "history.csv", ["time_s", "p_in_Pa", "p_out_Pa"])
    section, flow, pressure = rows(run / "sections.csv", ["time_s", "flow_m3_s", "p_Pa"])
    moved, widened = rows(run / "probes.csv", ["time_s", "uy_m"])
    beats = math.floor(time[-1] / period + 1e-6)
    curves = {
        "pressure / kPa": (section, [1e-3 * p for p in pressure]),
        "flow / (ml/s)": (section, [1e6 * q for q in flow]),
        "change of radius / mm": (moved, [1e3 * u for u in widened]),
        "pressure, inlet less outlet / kPa": (time, [1e-3 * (a - b) for a, b in zip(p_in, p_out)]),
    }
    first = period * (beats - 1)
    found = {}
    for name, (times, values) in curves.items():
        beat = [(t - first, v) for t, v in zip(times, values) if first + 1e-9 < t <= first + period + 1e-9]
        found[name] = [list(column) for column in zip(*beat)]
    found["change of radius / mm"][1] = from_least(found["change of radius / mm"][1])
    return found


def from_least(values):
    return [value - min(values) for value in values]


def published(vessel, kind):
    """Times and values of the published quantities, in the order of those of a run."""
    keys = ["t_s", "p_kPa", "Q_ml_s", "dr_mm"] + (["dp_in_out_kPa"] if kind == "3d" else [])
    times, *found = rows(HERE / f"{vessel}-{kind}.csv", keys)
    found[2] = from_least(found[2])
    later = LATER.get((vessel, kind), 0.0)
    return [([t - later for t in times], values) for values in found]


def main():
    run, vessel, *other = sys.argv[1:]
    period = PERIOD[vessel]
    ours = computed(pathlib.Path(run), period)
    if other:
        references = {pathlib.Path(other[0]).name: computed(pathlib.Path(other[0]), period).values()}
    else:
        references = {kind: published(vessel, kind) for kind in ("3d", "1d")}
    print("| | here | compared with | rms | largest |\n| --- | --- | --- | --- | --- |")
    for kind, reference in references.items():
        for (name, (when, values)), (times, theirs) in zip(ours.items(), reference):
            pairs = [(v, at(t, times, theirs, period)) for t, v in zip(when, values)]
            scale = max(theirs)
            rms = math.sqrt(sum((a - b) ** 2 for a, b in pairs) / len(pairs)) / scale
            extremes = ["{:.3f}, {:.3f}, {:.3f}".format(max(x), min(x), sum(x) / len(x)) for x in (values, theirs)]
            share = max(values) / scale - 1
            print(f"| {name} | {extremes[0]} | {extremes[1]} ({kind}) | {100 * rms:.2f} % | {100 * share:+.2f} % |")


main()
