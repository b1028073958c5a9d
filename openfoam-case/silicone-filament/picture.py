#!/usr/bin/env python3
"""Draws the speed of the fluid in the plane x = 0 and the filament at the end of a run: `picture.py RUN OUT.png`.

Needs VTK (`pip install vtk`)."""

import pathlib
import sys

import vtk

run, out = map(pathlib.Path, sys.argv[1:])
foam = vtk.vtkOpenFOAMReader()
foam.SetFileName(str(run / "openfoam/fluid.foam"))
foam.CreateCellToPointOn()
foam.UpdateInformation()
times = foam.GetTimeValues()
foam.SetTimeValue(times.GetValue(times.GetNumberOfTuples() - 1))
foam.DisableAllPatchArrays()
foam.SetPatchArrayStatus("internalMesh", 1)
foam.ReadZonesOff()
foam.Update()

plane = vtk.vtkPlane()
plane.SetOrigin(1e-5, 0.0, 0.0)
plane.SetNormal(1.0, 0.0, 0.0)
cut = vtk.vtkCutter()
cut.SetCutFunction(plane)
cut.SetInputConnection(foam.GetOutputPort())
flat = vtk.vtkCompositeDataGeometryFilter()
flat.SetInputConnection(cut.GetOutputPort())
speed = vtk.vtkArrayCalculator()
speed.SetInputConnection(flat.GetOutputPort())
speed.AddVectorArrayName("U")
speed.SetResultArrayName("speed")
speed.SetFunction("mag(U)")
speed.Update()

colours = vtk.vtkColorTransferFunction()
for value, colour in ((0.0, (0.96, 0.97, 0.99)), (0.2, (0.62, 0.79, 0.88)), (0.4, (0.26, 0.57, 0.78)),
                      (0.75, (0.03, 0.19, 0.42))):
    colours.AddRGBPoint(value, *colour)
scene = vtk.vtkRenderer()
scene.SetBackground(1, 1, 1)


def show(port, colour=None):
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputConnection(port)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    if colour:
        mapper.ScalarVisibilityOff()
        actor.GetProperty().SetColor(*colour)
        actor.GetProperty().LightingOn()
    else:
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("speed")
        mapper.SetLookupTable(colours)
        mapper.UseLookupTableScalarRangeOn()
    scene.AddActor(actor)


show(speed.GetOutputPort())
wall = vtk.vtkXMLUnstructuredGridReader()
wall.SetFileName(str(sorted((run / "structure").glob("*.vtu"))[-1]))
bent = vtk.vtkWarpVector()
bent.SetInputConnection(wall.GetOutputPort())
bent.SetInputArrayToProcess(0, 0, 0, 0, "displacement_m")
skin = vtk.vtkDataSetSurfaceFilter()
skin.SetInputConnection(bent.GetOutputPort())
# In front of the plane, seen along x
aside = vtk.vtkTransform()
aside.Translate(-0.02, 0.0, 0.0)
front = vtk.vtkTransformFilter()
front.SetTransform(aside)
front.SetInputConnection(skin.GetOutputPort())
show(front.GetOutputPort(), (0.87, 0.42, 0.2))

bar = vtk.vtkScalarBarActor()
bar.SetLookupTable(colours)
bar.SetTitle("speed, m/s")
bar.SetNumberOfLabels(6)
bar.SetLabelFormat("%.2f")
bar.UnconstrainedFontSizeOn()
bar.SetOrientationToHorizontal()
bar.SetPosition(0.3, 0.01)
bar.SetWidth(0.4)
bar.SetHeight(0.1)
for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
    text.SetColor(0.1, 0.1, 0.1)
    text.SetFontSize(16)
    text.ItalicOff()
    text.BoldOff()
    text.ShadowOff()
scene.AddViewProp(bar)

window = vtk.vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetMultiSamples(8)
window.SetSize(1200, 640)
window.AddRenderer(scene)
camera = scene.GetActiveCamera()
camera.ParallelProjectionOn()
camera.SetPosition(-1.0, -0.005, 0.056)
camera.SetFocalPoint(0.0, -0.005, 0.056)
camera.SetViewUp(0.0, 1.0, 0.0)
camera.SetParallelScale(0.0465)
scene.ResetCameraClippingRange()
window.Render()
image = vtk.vtkWindowToImageFilter()
image.SetInput(window)
writer = vtk.vtkPNGWriter()
writer.SetFileName(str(out))
writer.SetInputConnection(image.GetOutputPort())
writer.Write()
