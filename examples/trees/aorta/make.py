"""Writes factors.csv: the wall of the aortic bifurcation is thicker around the apex.

Between the two iliac arteries the lumen is flat there, and a wall as thin as elsewhere does not carry the pressure.
"""

import math

LENGTH, ILIAC, HALF_ANGLE = 0.086, 0.085, math.radians(37.5)  # m, m, rad
MOST, AT, WIDTH = 1.8, 0.005, 0.010  # largest factor; behind the bifurcation, m; of the bell, m

with open("factors.csv", "w", encoding="utf-8") as file:
    file.write("x,y,z,factor\n")
    for side in (1, -1):
        for i in range(round((LENGTH + ILIAC) / 1e-3) + 1):
            s = 1e-3 * i - LENGTH
            factor = 1 + (MOST - 1) * math.exp(-(((s - AT) / WIDTH) ** 2))
            x = side * max(s, 0) * math.sin(HALF_ANGLE)
            z = LENGTH + min(s, 0) + max(s, 0) * math.cos(HALF_ANGLE)
            file.write(f"{x:.6g},0,{z:.6g},{factor:.6g}\n")
