#!/usr/bin/env python3
"""Writes lumen.stl and centre-line.csv of a bent, tapering vessel with an irregular lumen, in millimetres: what a segmentation
and a centre-line tool would give."""

import math
import struct
from pathlib import Path

LENGTH, BEND = 50.0, 45.0  # of the centre-line, and the radius of its arc
SLICES, SIDES = 100, 36
BEYOND = 1.5  # the surface goes on so far beyond the ends of the line


def frame(s):
    a = s / BEND
    origin = (BEND * math.sin(a), BEND * (1 - math.cos(a)), 0.1 * s)
    return origin, (-math.sin(a), math.cos(a), 0.0), (0.0, 0.0, 1.0)


def radius(s, phi):
    taper = 3.2 - 0.8 * s / LENGTH
    plaque = 0.9 * math.exp(-(((s - 24) / 5) ** 2)) * (0.5 + 0.5 * math.cos(phi - 1.0)) ** 2
    oval = 0.15 * math.cos(2 * phi + 0.05 * s)
    return taper * (1 - 0.55 * plaque) + oval


def point(i, j):
    s = -BEYOND + (LENGTH + 2 * BEYOND) * i / SLICES
    phi = 2 * math.pi * (j % SIDES + 0.5 * (i % 2)) / SIDES
    origin, first, second = frame(s)
    r = radius(s, phi)
    return tuple(o + r * (math.cos(phi) * a + math.sin(phi) * b) for o, a, b in zip(origin, first, second))


def main():
    triangles = []
    for i in range(SLICES):
        for j in range(SIDES):
            odd = i % 2
            a, b = point(i, j), point(i, j + 1)
            c, d = point(i + 1, j + odd), point(i + 1, j + 1 + odd)
            triangles += [(a, b, c), (b, d, c)]
    here = Path(__file__).parent
    with open(here / "lumen.stl", "wb") as file:
        file.write(b"a vessel, in millimetres".ljust(80) + struct.pack("<I", len(triangles)))
        for triangle in triangles:
            corners = [x for corner in triangle for x in corner]
            file.write(struct.pack("<12fH", 0, 0, 0, *corners, 0))
    rows = ["x,y,z"]
    for k in range(51):
        x, y, z = frame(LENGTH * k / 50)[0]
        rows.append(f"{x:.4f},{y:.4f},{z:.4f}")
    (here / "centre-line.csv").write_text("\n".join(rows) + "\n")


main()
