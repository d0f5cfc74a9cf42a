"""Draws the last frame of a fetched result with ParaView, deformed and coloured by temperature.

Usage: pvpython paraview_slab.py RESULTS.xdmf [PICTURE.png]
The picture lies beside the results, under their name, unless it is given. Where there is no display it is
drawn by xvfb-run (Debian's package xvfb).
"""
import os
import shutil
import sys

from paraview import simple
from vtkmodules.vtkRenderingCore import vtkRenderWindow

if not 2 <= len(sys.argv) <= 3:
    sys.exit(__doc__)
results = os.path.abspath(sys.argv[1])  # the reader needs the folder of the file
if not os.path.isfile(results):
    sys.exit(f"{sys.argv[1]} is not there; `dccast fetch JOB` writes it")

# ParaView of Debian ends by a signal without a display; other builds need none.
if "X" in vtkRenderWindow().GetClassName() and not os.environ.get("DISPLAY"):
    without_display = shutil.which("xvfb-run")
    if not without_display:
        sys.exit("there is no display; install xvfb, which stands for one: apt install xvfb")
    os.execv(without_display, [without_display, "-a", "pvpython", *sys.argv])

picture = sys.argv[2] if len(sys.argv) == 3 else os.path.splitext(results)[0] + ".png"

source = simple.Xdmf3ReaderS(FileName=[results])
view = simple.CreateView("RenderView")
view.ViewSize = [900, 520]
if source.TimestepValues:  # results-end.xdmf has the last frame alone
    view.ViewTime = source.TimestepValues[-1]
view.UseColorPaletteForBackground = 0
view.Background = [1, 1, 1]
view.OrientationAxesLabelColor = [0, 0, 0]

slab = simple.WarpByVector(Input=source)
slab.Vectors = ["POINTS", "displacement_m"]
shown = simple.Show(slab, view)
simple.ColorBy(shown, ("POINTS", "temperature_c"))
shown.RescaleTransferFunctionToDataRange(False)
shown.SetScalarBarVisibility(view, True)
colours = simple.GetColorTransferFunction("temperature_c")
colours.ApplyPreset("Inferno (matplotlib)", True)
bar = simple.GetScalarBar(colours, view)
bar.Title, bar.ComponentTitle = "temperature, °C", ""
bar.LabelFormat = bar.RangeLabelFormat = "%.0f"
bar.TitleColor = bar.LabelColor = [0, 0, 0]

view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [2, 1.6, 0.7], [0.3, 0.15, 0.1], [0, 0, 1]
simple.ResetCamera(view)
simple.Render(view)
simple.SaveScreenshot(picture, view)
print(picture)
