#!/usr/bin/env python3
"""Writes lines.vtp: centre-lines of a carotid bifurcation as VMTK has them, from the common carotid to the internal and
the external one, with the radius of the largest sphere. Lengths in mm."""

import math
import pathlib


def smooth(x):
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def line(angle_deg, lean_deg, length, radius):
    """Points and radii: 40 mm straight up, then a bend to the final direction within 12 mm."""
    points, radii = [], []
    x = y = 0.0
    z = -40.0
    step = 0.5
    for i in range(round((40.0 + length) / step) + 1):
        s = i * step - 40.0
        points.append((x, y, z))
        radii.append(radius(s))
        share = smooth((s + 5.0) / 12.0)
        a, b = math.radians(angle_deg) * share, math.radians(lean_deg) * share
        x += step * math.sin(a)
        y += step * math.cos(a) * math.sin(b)
        z += step * math.cos(a) * math.cos(b)
    return points, radii


def internal(s):
    """The bulb: 3.1 mm, widest 8 mm past the bifurcation, 2.4 mm from 20 mm on."""
    if s < 8.0:
        return 3.1 + 0.4 * smooth(s / 8.0)
    return 3.5 - 1.1 * smooth((s - 8.0) / 12.0)


def external(s):
    return 3.1 - 1.0 * smooth(s / 8.0)


def numbers(values):
    return " ".join(f"{value:.4f}" for value in values)


lines = [line(26.0, 6.0, 40.0, internal), line(-30.0, 0.0, 34.0, external)]
points = [point for points, _ in lines for point in points]
radii = [radius for _, radii in lines for radius in radii]
first = len(lines[0][0])
offsets = f"{first} {len(points)}"
text = f"""<?xml version="1.0"?>
<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian">
<PolyData><Piece NumberOfPoints="{len(points)}" NumberOfVerts="0" NumberOfLines="2" NumberOfStrips="0" NumberOfPolys="0">
<PointData><DataArray type="Float64" Name="MaximumInscribedSphereRadius" format="ascii">
{numbers(radii)}
</DataArray></PointData>
<CellData><DataArray type="Int32" Name="CenterlineIds" format="ascii">0 1</DataArray></CellData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
{numbers(x for point in points for x in point)}
</DataArray></Points>
<Lines><DataArray type="Int32" Name="connectivity" format="ascii">
{" ".join(str(i) for i in range(len(points)))}
</DataArray><DataArray type="Int32" Name="offsets" format="ascii">{offsets}</DataArray></Lines>
</Piece></PolyData></VTKFile>
"""
(pathlib.Path(__file__).parent / "lines.vtp").write_text(text)
