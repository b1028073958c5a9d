"""Opens a run of fsi-driver in ParaView: `paraview --script=paraview.py`, or Tools > Python Shell > Run Script.

Blood: speed in a longitudinal cut. Lumen: oscillating shear index over the evaluated window, at its mean position.
Wall: von Mises stress on the displaced outer half.
"""
import os

from paraview.simple import (
    Clip,
    ColorBy,
    GetActiveViewOrCreate,
    GetAnimationScene,
    OpenFOAMReader,
    PVDReader,
    Show,
    Slice,
    WarpByVector,
)

here = os.path.dirname(os.path.abspath(__file__))
view = GetActiveViewOrCreate("RenderView")


def show(source, where, name, representation="Surface"):
    """Shows `source`, coloured by the field `name`, with its colour bar."""
    display = Show(source, view)
    display.SetRepresentationType(representation)
    ColorBy(display, (where, name))
    display.RescaleTransferFunctionToDataRange(True)
    display.SetScalarBarVisibility(view, True)
    return display


blood = OpenFOAMReader(FileName=os.path.join(here, "openfoam", "fluid.foam"))
blood.MeshRegions = ["internalMesh"]
cut = Slice(Input=blood)
cut.SliceType = "Plane"
cut.SliceType.Origin = [0.03, 0.0, 0.0]
cut.SliceType.Normal = [0.0, 0.0, 1.0]
show(cut, "POINTS", "U")

if os.path.exists(os.path.join(here, "wall-shear.pvd")):
    lumen = PVDReader(FileName=os.path.join(here, "wall-shear.pvd"))
    display = show(lumen, "CELLS", "OSI")
    display.Opacity = 0.5

wall = WarpByVector(Input=PVDReader(FileName=os.path.join(here, "structure.pvd")))
wall.Vectors = ["POINTS", "displacement_m"]
half = Clip(Input=wall)
half.ClipType = "Plane"
half.ClipType.Origin = [0.03, 0.0, 0.0]
half.ClipType.Normal = [0.0, 0.0, 1.0]
show(half, "POINTS", "von_mises_Pa")

GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
view.ResetCamera()
