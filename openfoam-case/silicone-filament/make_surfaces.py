#!/usr/bin/env python3
"""Writes the surfaces of the phantom and of the filament as STL (m): `make_surfaces.py FOLDER`.

The published sizes are those of the openings, of the filament and where they lie. Between the inlets, circles of 21.9
mm, and the outlet, a circle of 76.2 mm, each inlet is taken to widen as half a cosine does, over the length with which
the two meet at the clamped end of the filament, on both its sides. README.md says what speaks for that.
"""

import math
import pathlib
import sys

INLET, OUTLET = 10.95, 38.1  # radii, mm
CENTRE = OUTLET - INLET  # of an inlet: it touches the outlet's circle
BEGIN, END = -29.5, 339.5  # planes of the openings: 250 mm downstream of the phantom's end at 89.5 mm
FILAMENT = (5.5, 1.0, 65.0)  # half its width, half its thickness, its length
AROUND = 96  # points around an inlet


def cone_length():
    """Such that the inlets are half the filament's thickness from the middle at z = 0."""
    share = (CENTRE - INLET - FILAMENT[1]) / (2.0 * CENTRE)
    return -BEGIN * math.pi / math.acos(1.0 - 2.0 * share)


def circle(z):
    """Centre and radius (mm) of the upper circle of the cross-section at z."""
    share = min((z - BEGIN) / cone_length(), 1.0)
    wide = 0.5 * (1.0 - math.cos(math.pi * share))
    return CENTRE * (1.0 - wide), INLET + (OUTLET - INLET) * wide


def ring(z):
    """The upper circle as far as it lies above the middle, from one side to the other, seen against the flow."""
    centre, radius = circle(z)
    half = math.pi if centre >= radius else math.acos(-centre / radius)
    angles = [half * (2.0 * i / AROUND - 1.0) for i in range(AROUND + 1)]
    return [(radius * math.sin(a), max(centre + radius * math.cos(a), 0.0), z) for a in angles]


def strip(below, above):
    for a, b, c, d in zip(below, below[1:], above, above[1:]):
        yield from ((a, b, d), (a, d, c))


def fan(points, middle):
    return [(middle, a, b) for a, b in zip(points, points[1:])]


def phantom():
    """Triangles of each patch."""
    # Where the circles first meet the section widens as a square root does
    crotch = BEGIN + cone_length() / math.pi * math.acos(1.0 - (CENTRE - INLET) / CENTRE)
    places = [BEGIN + 1.0 * i for i in range(math.ceil(crotch - BEGIN))]
    places += [crotch + 0.02 * i * i for i in range(20)]
    places += [z for z in (9.0 + i for i in range(60)) if z < BEGIN + cone_length()]
    places += [BEGIN + cone_length() + (END - BEGIN - cone_length()) * i / 30 for i in range(31)]
    rings = [ring(z) for z in places]
    upper = [t for a, b in zip(rings, rings[1:]) for t in strip(a, b)]
    inlet = fan(rings[0], (0.0, CENTRE, BEGIN))
    outlet = fan(rings[-1], (0.0, 0.0, END))
    lower = lambda triangles: [tuple((x, -y, z) for x, y, z in reversed(t)) for t in triangles]
    return {
        "wall": upper + lower(upper),
        "upperInlet": inlet,
        "lowerInlet": lower(inlet),
        "outlet": outlet + lower(outlet),
    }


def root(x, y):
    """Where the phantom's wall is at this place of the cross-section, between the inlets."""
    low, high = -1.0, 20.0
    for _ in range(60):
        z = 0.5 * (low + high)
        centre, radius = circle(z)
        low, high = (z, high) if centre - math.sqrt(radius**2 - x**2) > abs(y) else (low, z)
    return high


def filament():
    """Its surface in the fluid."""
    x, y, z = FILAMENT
    corners = [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)]
    around = []
    for (a, b), (c, d), parts in zip(corners, corners[1:], (22, 4, 22, 4)):
        around += [(a + (c - a) * i / parts, b + (d - b) * i / parts) for i in range(parts)]
    around.append(corners[0])
    rings = [[(a, b, low + (z - low) * i / 60) for a, b in around for low in [root(a, b)]]
             for i in range(61)]
    sides = [t for a, b in zip(rings, rings[1:]) for t in strip(a, b)]
    return sides + fan(rings[-1], (0.0, 0.0, z))


def write(path, solids):
    with open(path, "w") as out:
        for name, triangles in solids.items():
            print(f"solid {name}", file=out)
            for triangle in triangles:
                print(" facet normal 0 0 0\n  outer loop", file=out)
                for point in triangle:
                    print("   vertex", *(f"{1e-3 * round(c, 9) + 0.0:.9g}" for c in point), file=out)
                print("  endloop\n endfacet", file=out)
            print(f"endsolid {name}", file=out)


folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
write(folder / "phantom.stl", phantom())
write(folder / "filament.stl", {"filament": filament()})
