"""A flow solver in Python as the fluid of fsi-driver: the fluid's side of of-adapter/PROTOCOL.md, version 3.

    import fsi_fluid

    class MyFluid(fsi_fluid.Fluid):
        ...

    fsi_fluid.serve(MyFluid)

Needs numpy. All quantities are in SI units.
"""

import os
import socket
import struct
import sys
import time
import traceback
from dataclasses import dataclass
from pathlib import Path

import numpy as np

VERSION = 3
_HELLO, _WELCOME, _SOLVE, _SOLVED, _ACCEPT, _ACCEPTED, _STOP, _FAILURE, _DISCARD = range(1, 10)
_NAMES = "HELLO WELCOME SOLVE SOLVED ACCEPT ACCEPTED STOP FAILURE DISCARD".split()
_LONGEST_TEXT = 4096
_LONGEST_STATE = 1 << 28


class ProtocolError(Exception):
    """The driver said what it must not say, or has gone."""


@dataclass
class Start:
    """What the driver tells in the environment."""

    transport: str  # "socket" or "files"
    address: Path  # the socket, or the folder of the files
    driver: int  # number of the driver's process
    time: float  # where the run starts, s
    time_step: float  # s
    case: Path  # the case with all its values (TOML)
    folder: Path  # the fluid's own folder
    wall: Path  # the wet surface as a Wavefront OBJ file

    @classmethod
    def from_environment(cls):
        """Of this process."""
        try:
            return cls(
                transport=os.environ["FSI_TRANSPORT"],
                address=Path(os.environ["FSI_ADDRESS"]),
                driver=int(os.environ["FSI_DRIVER"]),
                time=float(os.environ["FSI_START_TIME_S"]),
                time_step=float(os.environ["FSI_TIME_STEP_S"]),
                case=Path(os.environ["FSI_CASE"]),
                folder=Path(os.environ["FSI_FOLDER"]),
                wall=Path(os.environ["FSI_WALL"]),
            )
        except KeyError as missing:
            raise SystemExit(
                f"{missing} is not set: this program is started by fsi-driver (fluid.command), or with what it has "
                "written into connection.env (fluid.await)"
            ) from None


@dataclass
class Wall:
    """The wet surface in the reference configuration."""

    points: np.ndarray  # (P, 3), m
    faces: list  # of each face the indices of its points; by the right-hand rule its normal points out of the fluid
    centres: np.ndarray  # (F, 3), m

    @classmethod
    def read(cls, path):
        """The wall as fsi-driver has written it for fluids without a mesh of their own."""
        points, faces = [], []
        for line in Path(path).read_text().splitlines():
            word, *rest = line.split() or [""]
            if word == "v":
                points.append([float(x) for x in rest])
            elif word == "f":
                faces.append([int(i) - 1 for i in rest])
        points = np.array(points)
        return cls(points, faces, np.array([points[face].mean(axis=0) for face in faces]))


@dataclass
class Opening:
    """Where the fluid enters or leaves its domain."""

    name: str
    has_model: bool = False  # whether a model with a pressure of its own, such as a windkessel, is downstream of it


@dataclass
class Report:
    """What the solver reports of a finished step."""

    openings: list  # of each opening (flow into the domain m³/s, mean pressure Pa, pressure of the model Pa or 0)
    volume: float  # of the whole domain, m³
    wall_shear: np.ndarray  # (F, 3): the fluid's viscous force on the wall per deformed area, Pa
    wall_velocity_mismatch: float = 0.0  # m/s


class Fluid:
    """What a flow solver must know. One object lives as long as the process."""

    #: The wet surface; its order of points and faces is the fluid's own choice, and the same at every start.
    wall: Wall
    #: The inlet first.
    openings: list
    #: Volume of the part of the domain whose wall is rigid, m³.
    rigid_volume = 0.0

    def __init__(self, start: Start):
        """At the beginning of a run."""

    def volume(self) -> float:
        """Volume of the whole domain now, m³."""
        raise NotImplementedError

    def restore(self, state: bytes):
        """Goes on from what `state()` gave, perhaps in an earlier process."""
        raise NotImplementedError

    def solve(self, displacement, time_step, from_old_state, max_correctors, residual):
        """Solves the current time step for the displacement (P, 3) of the wall's points at its end, m, and returns the
        load on the faces (F, 3), Pa: `p n` less the viscous stress, n out of the fluid. It is called again and again with other displacements, always
        from the same old state, until `accept`; with `from_old_state` the answer must not depend on the trials before."""
        raise NotImplementedError

    def accept(self) -> Report:
        """Keeps the last trial."""
        raise NotImplementedError

    def state(self) -> bytes:
        """With this `restore` can go on from the last accepted step: all of it, or the name of what was left on disk."""
        raise NotImplementedError

    def discard(self, state: bytes):
        """A state is not needed any more."""


def serve(fluid_class):
    """Makes the fluid and answers the driver until it says STOP; then the process ends with exit code 0."""
    start = Start.from_environment()
    line = _Socket(start) if start.transport == "socket" else _Files(start)
    try:
        fluid = fluid_class(start)
        _converse(line, fluid, start)
    except ProtocolError as error:
        line.fail(str(error))
        sys.exit(f"fsi_fluid: {error}")
    except Exception as error:  # whatever it is, the driver shall know why
        line.fail(f"{type(error).__name__}: {error}")
        traceback.print_exc()
        sys.exit(1)


def _converse(line, fluid, start):
    wall = fluid.wall
    points, faces = len(wall.points), len(wall.faces)
    hello = struct.pack("<4d", start.time, start.time_step, fluid.volume(), fluid.rigid_volume)
    vertices = sum(len(face) for face in wall.faces)
    hello += struct.pack("<4I", points, faces, vertices, len(fluid.openings))
    hello += _vectors(wall.points, points, "wall.points")
    hello += np.array([len(face) for face in wall.faces], "<u4").tobytes()
    hello += np.concatenate([np.asarray(face, "<u4") for face in wall.faces]).tobytes()
    hello += _vectors(wall.centres, faces, "wall.centres")
    for opening in fluid.openings:
        name = opening.name.encode()
        hello += struct.pack("<2I", opening.has_model, len(name)) + name
    line.send(_HELLO, hello)
    kind, welcome = line.receive({_WELCOME: (24, 24 + _LONGEST_STATE)})
    time_, time_step, its_points, its_faces = struct.unpack("<2d2I", welcome[:24])
    ours = (start.time, start.time_step, points, faces)
    if not np.allclose((time_, time_step), ours[:2], rtol=1e-9, atol=1e-12) or (its_points, its_faces) != ours[2:]:
        raise ProtocolError(f"driver and fluid do not fit: {(time_, time_step, its_points, its_faces)} there, {ours} here")
    if welcome[24:]:
        fluid.restore(welcome[24:])

    now, step = start.time, None
    solve, accept = {_SOLVE: (24 + 24 * points,) * 2}, {_ACCEPT: (4, 4)}
    always = {_STOP: (0, 0), _DISCARD: (0, _LONGEST_STATE)}
    while True:
        kind, payload = line.receive({**solve, **always, **(accept if step else {})})
        if kind == _STOP:
            return
        if kind == _DISCARD:
            fluid.discard(payload)
        elif kind == _SOLVE:
            correctors, flags, residual, time_step = struct.unpack("<2I2d", payload[:24])
            displacement = np.frombuffer(payload[24:], "<f8").reshape(-1, 3)
            if correctors == 0 or flags > 1 or not (np.isfinite(residual) and 0 < time_step < np.inf):
                raise ProtocolError(
                    f"SOLVE with {correctors} correctors, flags {flags}, residual {residual} and a time step of {time_step} s"
                )
            if not np.isfinite(displacement).all():
                raise ProtocolError("SOLVE with a displacement that is not finite")
            if step not in (None, time_step) and not flags:
                raise ProtocolError(f"an open time step of {step} s became {time_step} s long without going back")
            step = time_step
            tractions = fluid.solve(displacement, time_step, bool(flags), correctors, residual)
            answer = struct.pack("<2I2d", 1, 0, now + time_step, 0.0)
            line.send(_SOLVED, answer + _vectors(tractions, faces, "tractions"))
        else:
            (flags,) = struct.unpack("<I", payload)
            if flags > 1:
                raise ProtocolError(f"ACCEPT with flags {flags}")
            now, step = now + step, None
            report = fluid.accept()
            answer = struct.pack("<3d", now, report.volume, report.wall_velocity_mismatch)
            for opening in report.openings:
                answer += struct.pack("<3d", *opening)
            answer += _vectors(report.wall_shear, faces, "wall_shear")
            line.send(_ACCEPTED, answer + (fluid.state() if flags else b""))


def _vectors(values, n, name):
    values = np.asarray(values, "<f8")
    if values.shape != (n, 3):
        raise ValueError(f"{name} has the shape {values.shape}, expected {(n, 3)}")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} has a value that is not finite")
    return values.tobytes()


class _Line:
    """Messages over some way."""

    def send(self, kind, payload):
        self.write(b"FSIP" + struct.pack("<HHQ", VERSION, kind, len(payload)) + payload)

    def receive(self, allowed):
        """The next message: its kind, which is one of `allowed` (with the least and the greatest length), and its payload."""
        head = self.read_head()
        magic, version, kind, length = struct.unpack("<4sHHQ", head)
        if magic != b"FSIP":
            raise ProtocolError("the driver sent bytes that are not a message")
        if version != VERSION:
            raise ProtocolError(f"the driver speaks protocol version {version}, this fluid speaks {VERSION}")
        if not 1 <= kind <= len(_NAMES):
            raise ProtocolError(f"the driver sent a message of unknown kind {kind}")
        name = _NAMES[kind - 1]
        least, most = {**allowed, _FAILURE: (0, _LONGEST_TEXT)}.get(kind, (None, None))
        if least is None:
            expected = ", ".join(_NAMES[kind - 1] for kind in allowed)
            raise ProtocolError(f"the driver sent {name}, expected one of {expected}")
        if not least <= length <= most:
            raise ProtocolError(f"the driver's {name} has {length} bytes, expected {least} to {most}")
        payload = self.read(length)
        if kind == _FAILURE:
            raise ProtocolError(f"the driver ended: {payload.decode(errors='replace')}")
        return kind, payload

    def fail(self, text):
        """Tells the driver why this process ends, if it can be reached."""
        try:
            self.send(_FAILURE, text.encode()[:_LONGEST_TEXT])
        except (OSError, ProtocolError):
            pass


class _Socket(_Line):
    def __init__(self, start):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(str(start.address))

    def write(self, message):
        self.socket.sendall(message)

    def read_head(self):
        return self.read(16)

    def read(self, length):
        parts, missing = [], length
        while missing:
            part = self.socket.recv(min(missing, 1 << 20))
            if not part:
                raise ProtocolError("the driver has closed the connection")
            parts.append(part)
            missing -= len(part)
        return b"".join(parts)


class _Files(_Line):
    def __init__(self, start):
        self.folder, self.driver = start.address, start.driver
        self.sent = self.received = 0
        self.born = self._birth()

    def _birth(self):
        """When the driver's process began: numbers of processes are used again."""
        try:
            return Path(f"/proc/{self.driver}/stat").read_text().rsplit(")", 1)[1].split()[19]
        except OSError:
            return None

    def write(self, message):
        self.sent += 1
        path = self.folder / f"{self.sent:08}.fluid"
        partial = path.with_suffix(".fluid.partial")
        partial.write_bytes(message)
        partial.rename(path)

    def read_head(self):
        self.received += 1
        path = self.folder / f"{self.received:08}.driver"
        pause, waited = 5e-5, 0.0
        while not path.exists():
            time.sleep(pause)
            waited += pause
            pause = min(1.25 * pause, 5e-3)
            if waited > 0.5:
                waited = 0.0
                if self.born is None or self._birth() != self.born:
                    raise ProtocolError("the driver's process has ended")
        self.message = path.read_bytes()
        path.unlink()
        if len(self.message) < 16:
            raise ProtocolError("the driver sent bytes that are not a message")
        return self.message[:16]

    def read(self, length):
        if len(self.message) != 16 + length:
            raise ProtocolError(f"a file of {len(self.message)} bytes, its frame announces {16 + length}")
        return self.message[16:]
