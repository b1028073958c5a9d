"""Writes carotid-measured.csv and aorta-measured.csv: the published curves in the fourth beat, for `output.measured`."""

import csv
import pathlib

HERE = pathlib.Path(__file__).parent
# Period, s; by how much later than the inflow the published curves start, s; mid-length and radius, m; diastolic
# pressure, kPa, at which displacements are zero.
VESSELS = {"carotid": (1.1, -0.056, 0.063, 3e-3, 10.932), "aorta": (0.955, 0.0, 0.120685, 12e-3, 9.466)}
STEP = 0.02  # s


def main():
    for vessel, (period, later, middle, radius, diastolic) in VESSELS.items():
        with open(HERE / f"{vessel}-3d.csv", encoding="utf-8") as file:
            table = csv.DictReader(line for line in file if not line.startswith("#"))
            rows = [[float(row[key]) for key in ("t_s", "p_kPa", "Q_ml_s", "dr_mm")] for row in table]
        at_rest = min(rows, key=lambda row: abs(row[1] - diastolic))[3]
        count = round(period / STEP - 0.5)
        beat = [STEP * (1 + i) for i in range(count)]
        with open(HERE / f"{vessel}-measured.csv", "w", encoding="utf-8") as file:
            file.write("# In three dimensions, Xiao and others (2014): benchmark of Boileau and others (2015)\n")
            file.write("series,quantity,time_s,x_m,y_m,z_m,value\n")
            for name, quantity, y, column, scale in (
                ("pressure", "wall_pressure_Pa", radius, 1, 1e3),
                ("middle", "flow_m3_s", 0, 2, 1e-6),
                ("radius", "displacement_y_m", radius, 3, 1e-3),
            ):
                for t in beat:
                    row = min(rows, key=lambda row: abs(row[0] - (t + later) % period))
                    value = scale * (row[column] - (at_rest if column == 3 else 0))
                    file.write(f"{name},{quantity},{3 * period + t:.4g},{middle},{y},0,{value:.6g}\n")


main()
