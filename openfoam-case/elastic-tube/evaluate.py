"""Peak, arrival and speed of the pulse in runs of the elastic tube: python3 evaluate.py RUN...

As solids4foam's verification of this case defines them: the peak is that of the parabola through the largest radial
displacement at mid-length and its neighbours; arrival, the time at which half of it is reached; the axial displacement,
its least value before 6.5 ms; the speed, the slope of place over the time at which the pressure on the axis reaches
half of that at the inlet, from 10 to 40 mm.
"""

import csv
import pathlib
import sys


def table(path, name, x, y):
    """Points (x, y) of each probe."""
    found = {}
    with open(path / name, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found.setdefault(int(row["probe"]), []).append((float(row[x]), float(row[y])))
    return found


def peak(points):
    """Time and height of the largest value."""
    i = max(range(1, len(points) - 1), key=lambda i: points[i][1])
    (a, p), (b, q), (_, r) = points[i - 1 : i + 2]
    slope, bend = (r - p) / 2, p - 2 * q + r
    return b - slope / bend * (b - a), q - slope**2 / (2 * bend)


def reached(points, level):
    """The time at which a level is reached first."""
    for (a, p), (b, q) in zip(points, points[1:]):
        if p < level <= q:
            return a + (b - a) * (level - p) / (q - p)
    raise ValueError(f"{level} is not reached")


def main():
    print("| run | peak / mm | at / ms | arrival / ms | axial / mm | speed / (m/s) |")
    print("| --- | --- | --- | --- | --- | --- |")
    for run in map(pathlib.Path, sys.argv[1:]):
        radial = table(run, "probes.csv", "time_s", "uy_m")[0]
        axial = table(run, "probes.csv", "time_s", "ux_m")[0]
        pressures = table(run, "fluid-probes.csv", "time_s", "p_Pa")
        when, height = peak(radial)
        arrival = reached(radial, height / 2)
        least = min(value for time, value in axial if time < 6.5e-3)
        places = [0.01 + 0.005 * i for i in range(7)]
        times = [reached(pressures[i], 0.5 * 1333.2) for i in range(7)]
        mean_x, mean_t = sum(places) / 7, sum(times) / 7
        over = sum((t - mean_t) ** 2 for t in times)
        speed = sum((x - mean_x) * (t - mean_t) for x, t in zip(places, times)) / over
        print(
            f"| {run.name} | {1e3 * height:.5f} | {1e3 * when:.3f} | {1e3 * arrival:.3f} | {1e3 * least:.5f} | {speed:.3f} |"
        )


main()
