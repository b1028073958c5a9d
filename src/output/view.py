"""Shows a run of fsi-driver in ParaView: `paraview --script=view.py`, or, as a picture, also without a display,
`pvpython view.py --screenshot out.png [--time SECONDS]`.

Blood: speed in the longitudinal cut. Wall: von Mises stress on the displaced half behind it. Lumen, below: the
oscillating shear index over the evaluated window, at the wall's mean position.
"""
import argparse
import os
import shutil
import subprocess
import sys

from paraview import simple

SIZE = [1600, 900]
BLACK = [0.0, 0.0, 0.0]
FOAM = os.path.join("openfoam", "system", "controlDict")
SERIES = "fluid.pvd"


def options():
    """What `pvpython` passes on; `paraview --script` passes nothing."""
    parser = argparse.ArgumentParser(prog="pvpython view.py")
    parser.add_argument("--screenshot", metavar="FILE.png", help="write a picture of %d x %d pixels" % tuple(SIZE))
    parser.add_argument("--time", type=float, metavar="SECONDS", help="which time [default: the last]")
    return parser.parse_args(sys.argv[1:] if is_alone() else [])


def is_alone():
    """Whether this is `pvpython view.py`, rather than a script within ParaView's window."""
    return bool(sys.argv) and sys.argv[0].endswith(".py")


def folder():
    """The folder of the run: that of this file."""
    candidates = [os.path.dirname(os.path.abspath(__file__))] if "__file__" in globals() else []
    # `paraview --script=…` does not tell a script its own name.
    try:
        with open("/proc/self/cmdline", "rb") as words:
            words = [os.fsdecode(word) for word in words.read().split(b"\0")]
        scripts = [word.split("=", 1)[-1] for word in words if word.endswith(".py")]
        candidates += [os.path.dirname(os.path.abspath(script)) for script in scripts]
    except OSError:
        pass
    candidates.append(os.getcwd())
    for candidate in candidates:
        if any(os.path.isfile(os.path.join(candidate, file)) for file in (FOAM, SERIES)):
            return candidate
    places = " nor in ".join(candidates)
    sys.exit("view.py: no %s or %s in %s; start it in the folder of the run" % (FOAM, SERIES, places))


def display():
    """A display of its own for a ParaView that cannot draw without one; the process to end afterwards, if any."""
    from paraview.modules import vtkRemotingViews  # noqa: F401, makes the factory of windows known
    from vtkmodules.vtkRenderingCore import vtkRenderWindow
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401

    if os.environ.get("DISPLAY") or not vtkRenderWindow().GetClassName().startswith("vtkX"):
        return None
    if not shutil.which("Xvfb"):
        sys.exit("view.py: this ParaView draws on a display only, and there is none; install Xvfb (Debian: xvfb)")
    read, write = os.pipe()
    words = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1600x1200x24", "-nolisten", "tcp"]
    server = subprocess.Popen(words, pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as number:
        os.environ["DISPLAY"] = ":" + number.readline().strip()
    return server


def bounds(source):
    """Least and largest coordinate along x, y and z."""
    b = source.GetDataInformation().GetBounds()
    return [b[0], b[2], b[4]], [b[1], b[3], b[5]]


def cut(operation, source, kind, origin):
    """`source` cut by the plane z = constant through `origin`."""
    result = operation(Input=source)
    setattr(result, kind, "Plane")
    plane = getattr(result, kind)
    plane.Origin = origin
    plane.Normal = [0.0, 0.0, 1.0]
    return result


def load_blood(root):
    """The blood, from OpenFOAM's files or from the driver's own, and the name of its velocity."""
    series = os.path.join(root, SERIES)
    if os.path.isfile(series):
        return simple.PVDReader(FileName=series), "velocity_m_s"
    blood = simple.OpenFOAMReader(FileName=os.path.join(root, FOAM))
    if os.path.isdir(os.path.join(root, "openfoam", "processor0")):
        blood.CaseType = "Decomposed Case"
    blood.MeshRegions = ["internalMesh"]
    return blood, "U"


def load(root, scene, time):
    """The sources to be shown, each with where its field is and the field's name."""
    blood, velocity = load_blood(root)
    structure = simple.PVDReader(FileName=os.path.join(root, "structure.pvd"))
    wall = simple.WarpByVector(Input=structure)
    wall.Vectors = ["POINTS", "displacement_m"]
    averages = os.path.join(root, "wall-shear.pvd")
    lumen = simple.PVDReader(FileName=averages) if os.path.exists(averages) else None
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.GoToLast()
    if time is not None:
        scene.AnimationTime = time
    wall.UpdatePipeline(scene.AnimationTime)
    low, high = bounds(wall)
    middle = [0.5 * (a + b) for a, b in zip(low, high)]
    shown = [
        (cut(simple.Slice, blood, "SliceType", middle), "POINTS", velocity),
        (cut(simple.Clip, wall, "ClipType", middle), "POINTS", "von_mises_Pa"),
    ]
    if lumen is not None:
        lumen = simple.Transform(Input=lumen)
        lumen.Transform.Translate = [0.0, -1.3 * (high[1] - low[1]), 0.0]
        shown.append((lumen, "CELLS", "OSI"))
    return shown


def show(shown, view):
    """Draws each source coloured by its field, with a bar of colours on the right."""
    names = {"U": "speed / (m/s)", "velocity_m_s": "speed / (m/s)", "von_mises_Pa": "von Mises stress / Pa", "OSI": "oscillating shear index"}
    for i, (source, where, name) in enumerate(shown):
        drawn = simple.Show(source, view)
        drawn.SetRepresentationType("Surface")
        simple.ColorBy(drawn, (where, name))
        drawn.RescaleTransferFunctionToDataRange(True)
        drawn.SetScalarBarVisibility(view, True)
        colours = drawn.LookupTable
        colours.ApplyPreset("Inferno (matplotlib)", True)
        bar = simple.GetScalarBar(colours, view)
        bar.Title, bar.ComponentTitle = names[name], ""
        bar.TitleColor = bar.LabelColor = BLACK
        bar.Orientation, bar.WindowLocation = "Horizontal", "Any Location"
        bar.Position = [0.04 + 0.32 * i, 0.04]
        bar.ScalarBarLength, bar.ScalarBarThickness = 0.24, 16
        bar.TitleFontSize, bar.LabelFontSize = 18, 16
        low, high = colours.RGBPoints[0], colours.RGBPoints[-4]
        bar.UseCustomLabels, bar.CustomLabels = 1, [low, 0.5 * (low + high), high]
        bar.AddRangeLabels, bar.AutomaticLabelFormat, bar.LabelFormat = 0, 0, "%.2g"


def look(shown, view):
    """Turns the camera to the cut, all sources in sight above the bars."""
    ends = [bounds(source) for source, _, _ in shown]
    low = [min(end[0][d] for end in ends) for d in range(3)]
    high = [max(end[1][d] for end in ends) for d in range(3)]
    middle = [0.5 * (a + b) for a, b in zip(low, high)]
    size = [b - a for a, b in zip(low, high)]
    # The picture shows twice the parallel scale from bottom to top; the lowest fifth belongs to the bars.
    columns, rows = view.ViewSize
    half = 0.55 * max(size[1] / 0.8, size[0] * rows / columns)
    middle[1] -= 0.2 * half
    view.CameraParallelProjection = 1
    view.CameraFocalPoint = middle
    view.CameraPosition = [middle[0], middle[1], middle[2] + 4.0 * max(size)]
    view.CameraViewUp = [0.0, 1.0, 0.0]
    view.CameraParallelScale = half


def main():
    chosen = options()
    root = folder()
    server = display() if chosen.screenshot else None
    try:
        view = simple.GetActiveViewOrCreate("RenderView")
        if is_alone():
            view.ViewSize = SIZE
        view.UseColorPaletteForBackground = 0
        view.Background = [1.0, 1.0, 1.0]
        view.OrientationAxesLabelColor = BLACK
        shown = load(root, simple.GetAnimationScene(), chosen.time)
        show(shown, view)
        simple.Render(view)  # The first one turns the camera by itself.
        look(shown, view)
        simple.Render(view)
        if chosen.screenshot:
            simple.SaveScreenshot(chosen.screenshot, view, ImageResolution=SIZE)
        elif is_alone():
            simple.Interact(view)
    finally:
        if server:
            server.terminate()


main()
