"""What ParaView makes of a result: run by pvpython, prints JSON.

Usage: pvpython paraview_reads.py ./RESULTS.xdmf
"""
import json
import sys

from paraview import simple
from paraview.vtk.util.numpy_support import vtk_to_numpy


def last_frame(source):
    time = source.TimestepValues[-1]
    simple.UpdatePipeline(time=time, proxy=source)
    return simple.servermanager.Fetch(source)


def block_of(data):
    """A time series may come as a collection of one grid."""
    return data.GetBlock(0) if data.IsA("vtkMultiBlockDataSet") else data


def arrays(attributes):
    names = [attributes.GetArrayName(i) for i in range(attributes.GetNumberOfArrays())]
    return {name: vtk_to_numpy(attributes.GetArray(name)).tolist() for name in names}


def described(source):
    grid = block_of(last_frame(source))
    warped = simple.WarpByVector(Input=source)
    warped.Vectors = ["POINTS", "displacement_m"]
    simple.UpdatePipeline(time=source.TimestepValues[-1], proxy=warped)
    return {
        "times": list(source.TimestepValues),
        "points": vtk_to_numpy(grid.GetPoints().GetData()).tolist(),
        "cells": grid.GetNumberOfCells(),
        "point_fields": arrays(grid.GetPointData()),
        "cell_fields": arrays(grid.GetCellData()),
        "warped_bounds": list(warped.GetDataInformation().GetBounds()),
    }


print(json.dumps({"XDMFReader": described(simple.XDMFReader(FileNames=[sys.argv[1]])),
                  "Xdmf3ReaderS": described(simple.Xdmf3ReaderS(FileName=[sys.argv[1]]))}))
