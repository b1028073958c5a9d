"""Opens a run of fsi-driver in ParaView: `paraview --script=paraview.py`.

Blood: speed in the longitudinal cut z = 0. Wall: von Mises stress on the displaced half behind it. Lumen, below: the
oscillating shear index over the evaluated window, at the wall's mean position.
"""
import os

from paraview.simple import (
    Clip,
    ColorBy,
    GetActiveViewOrCreate,
    GetAnimationScene,
    GetScalarBar,
    OpenFOAMReader,
    PVDReader,
    Show,
    Slice,
    Transform,
    WarpByVector,
)

here = os.path.dirname(os.path.abspath(__file__))
view = GetActiveViewOrCreate("RenderView")
view.UseColorPaletteForBackground = 0
view.Background = [1.0, 1.0, 1.0]
view.OrientationAxesLabelColor = [0.0, 0.0, 0.0]


def cut(operation, source, kind):
    """`source` cut by the plane z = 0."""
    result = operation(Input=source)
    setattr(result, kind, "Plane")
    plane = getattr(result, kind)
    plane.Origin = [0.03, 0.0, 0.0]
    plane.Normal = [0.0, 0.0, 1.0]
    return result


blood = OpenFOAMReader(FileName=os.path.join(here, "openfoam", "fluid.foam"))
blood.MeshRegions = ["internalMesh"]
wall = WarpByVector(Input=PVDReader(FileName=os.path.join(here, "structure.pvd")))
wall.Vectors = ["POINTS", "displacement_m"]
shown = [
    (cut(Slice, blood, "SliceType"), "POINTS", "U"),
    (cut(Clip, wall, "ClipType"), "POINTS", "von_mises_Pa"),
]
if os.path.exists(os.path.join(here, "wall-shear.pvd")):
    lumen = Transform(Input=PVDReader(FileName=os.path.join(here, "wall-shear.pvd")))
    lumen.Transform.Translate = [0.0, -0.012, 0.0]
    shown.append((lumen, "CELLS", "OSI"))

scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToLast()
for source, where, name in shown:
    display = Show(source, view)
    display.SetRepresentationType("Surface")
    ColorBy(display, (where, name))
    display.RescaleTransferFunctionToDataRange(True)
    display.SetScalarBarVisibility(view, True)
    colours = display.LookupTable
    colours.ApplyPreset("Inferno (matplotlib)", True)
    bar = GetScalarBar(colours, view)
    bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
view.ResetCamera()
