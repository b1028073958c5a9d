#!/usr/bin/env python3
"""Blood in one dimension, in Python: a flow solver that couples to the wall of fsi-driver.

    fsi-driver --case openfoam-case/S-0.0 --preset demo --set 'fluid.command=["python3", "examples/python_fluid/tube.py"]'

Continuity and momentum of the flow Q through the areas A that the wall prescribes, by implicit Euler:

    dA/dt + dQ/dx = 0,        rho dQ/dt + A dp/dx + 8 pi mu Q/A = 0

(friction of Poiseuille's profile, no convection), with the case's inflow and windkessel. Q follows from the inlet on, then
p from the outlet back: no system of equations.
"""

import sys
import tomllib
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import fsi_fluid


class Tube(fsi_fluid.Fluid):
    """The straight deformable part of a case's vessel, along x; cells are the slices between its rings of points."""

    openings = [fsi_fluid.Opening("inlet"), fsi_fluid.Opening("outlet", has_model=True)]

    def __init__(self, start):
        case = tomllib.loads(start.case.read_text())
        self.blood, self.inflow_of = case["blood"], Inflow(case)
        self.ramp, self.windkessel = case["ramp"]["duration_s"], case["windkessel"]
        self.wall = fsi_fluid.Wall.read(start.wall)
        # Faces with the same x of their centre are a slice.
        x = np.round(self.wall.centres[:, 0], 9)
        middles, self.slice_of = np.unique(x, return_inverse=True)
        corners = np.array(self.wall.faces)  # all of four points
        ends = self.wall.points[corners][:, :, 0]
        self.lengths = np.array([np.ptp(ends[self.slice_of == i]) for i in range(len(middles))])
        self.corners = corners
        n = len(middles)
        area, _, _ = self.areas(np.zeros_like(self.wall.points))
        self.old = dict(time=start.time, area=area, flow=np.zeros(n + 1), model=self.windkessel["initial_pressure_Pa"])

    def areas(self, displacement):
        """Area of each slice, and area vector and centre of each face, of the displaced wall."""
        p = (self.wall.points + displacement)[self.corners]  # (F, 4, 3)
        vector = 0.5 * np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
        centre = p.mean(axis=1)
        share = 0.5 * (centre[:, 1] * vector[:, 1] + centre[:, 2] * vector[:, 2])
        return np.bincount(self.slice_of, share) / self.lengths, vector, centre

    def volume(self):
        return float(self.old["area"] @ self.lengths)

    def solve(self, displacement, time_step, from_old_state, max_correctors, residual):
        old, dt = self.old, time_step
        area, vector, _ = self.areas(displacement)
        if area.min() <= 0:
            raise ValueError(f"the tube has collapsed in slice {area.argmin()}")
        time = old["time"] + dt
        ramp = 0.5 * (1 - np.cos(np.pi * time / self.ramp)) if time < self.ramp else 1.0
        stored = np.cumsum(self.lengths * (area - old["area"])) / dt
        flow = ramp * self.inflow_of(time) - np.concatenate([[0.0], stored])
        # Windkessel, implicitly: C dp/dt + p/R = Q; the ramp scales what the vessel feels of it.
        R, C = self.windkessel["resistance_Pa_s_m3"], self.windkessel["compliance_m3_Pa"]
        model = (old["model"] * C / dt + flow[-1]) / (C / dt + 1 / R)
        # From the middle of a slice to that of the next, and from that of the last one to the outlet.
        rho, mu = self.blood["density_kg_m3"], self.blood["viscosity_Pa_s"]
        length = np.append(0.5 * (self.lengths[1:] + self.lengths[:-1]), 0.5 * self.lengths[-1])
        inertia = rho * (flow[1:] - old["flow"][1:]) / dt
        loss = length * (inertia + 8 * np.pi * mu * flow[1:] / area) / area
        pressure = ramp * model + np.cumsum(loss[::-1])[::-1]
        shear = 4 * mu * 0.5 * (flow[1:] + flow[:-1]) / (np.pi * (area / np.pi) ** 1.5)
        normal = vector / np.linalg.norm(vector, axis=1)[:, None]
        along = np.array([1.0, 0.0, 0.0]) - normal[:, :1] * normal
        self.shear = shear[self.slice_of, None] * along
        self.trial = dict(time=time, area=area, flow=flow, model=model)
        self.ends = (flow[0], pressure[0]), (-flow[-1], ramp * model)
        return pressure[self.slice_of, None] * normal + self.shear

    def accept(self):
        self.old = self.trial
        (inflow, p_in), (outflow, p_out) = self.ends
        openings = [(inflow, p_in, 0.0), (outflow, p_out, self.old["model"])]
        return fsi_fluid.Report(openings, self.volume(), self.shear)

    def state(self):
        old = self.old
        return np.concatenate([[old["time"], old["model"]], old["area"], old["flow"]]).astype("<f8").tobytes()

    def restore(self, state):
        numbers, n = np.frombuffer(state, "<f8"), len(self.lengths)
        if len(numbers) != 2 * n + 3:
            raise ValueError(f"a state of {len(numbers)} numbers, this tube has {2 * n + 3}")
        self.old = dict(time=numbers[0], model=numbers[1], area=numbers[2 : n + 2], flow=numbers[n + 2 :])


class Inflow:
    """The flow at the inlet that a case describes by its formula, before the ramp."""

    def __init__(self, case):
        self.curve, self.period = case["inflow"], case["time"]["period_s"]
        if "file" in self.curve:
            raise ValueError("inflow.file: this fluid knows the formula of [inflow] alone")

    def __call__(self, time):
        t, c = time % self.period, self.curve
        pulse = np.sin(np.pi * (t / c["systole_s"]) ** c["exponent"]) ** 2 if t < c["systole_s"] else 0.0
        return c["base_m3_s"] + c["amplitude_m3_s"] * pulse


if __name__ == "__main__":
    fsi_fluid.serve(Tube)
