#!/usr/bin/python3
"""Holds a result file beside core/results/SCHEMA.md and follows its sidecar, with h5py and h5dump.

Usage: check_results_file.py RESULTS.h5...     exit code 1 and a list of what differs, else 0
"""
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as xml

import h5py
import numpy as np

SCHEMA = pathlib.Path(__file__).resolve().parents[3] / "core/results/SCHEMA.md"
NUMPY_TYPE = {"f8": "<f8", "i8": "<i8", "i4": "<i4"}
NODES_OF_TOPOLOGY = {"Triangle": 3, "Quadrilateral": 4, "Tetrahedron": 4, "Hexahedron": 8}
COMPRESSED_FROM = 4096
TENSOR_COMPONENTS = {2: 4, 3: 6}


class Findings(list):
    """What differs from the contract, one line each."""

    def require(self, holds, text):
        if not holds:
            self.append(text)
        return holds


def schema_rows():
    """(first cell split at commas, other cells) of every table row of the schema."""
    for line in SCHEMA.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        names = re.findall(r"`([^`]+)`", cells[0])
        if line.startswith("| `") and names:
            yield names, cells[1:]


def schema_datasets():
    """name -> (type, unit) for /history and for /frames/NNNNNN, as the tables of the schema say."""
    history, frame = {}, {}
    for names, cells in schema_rows():
        for name in names:
            if cells[0] in NUMPY_TYPE and len(cells) == 3:
                history[name] = (cells[0], cells[1])
            elif len(cells) == 4 and cells[1] in NUMPY_TYPE and not name.startswith("/"):
                frame[name] = (cells[1], cells[2])
    return history, frame


def check_array(findings, dataset, kind, unit):
    where = dataset.name
    findings.require(dataset.dtype == np.dtype(NUMPY_TYPE[kind]), f"{where}: type {dataset.dtype}")
    findings.require(dataset.attrs.get("unit") == unit, f"{where}: unit {dataset.attrs.get('unit')}")
    findings.require(dataset.attrs.get("units") == unit, f"{where}: units {dataset.attrs.get('units')}")
    findings.require(bool(dataset.attrs.get("meaning")), f"{where}: no meaning")
    if dataset.size >= COMPRESSED_FROM:
        findings.require(dataset.compression == "gzip" and dataset.shuffle and dataset.fletcher32,
                         f"{where}: not shuffled, deflated and checked")
    if dataset.dtype.kind == "f" and not dataset.name.endswith("/gap_m"):
        findings.require(np.isfinite(dataset[()]).all(), f"{where}: not finite")


def check_root(findings, file):
    for name in ("schema_version", "program", "program_version", "build", "commit", "title",
                 "case_sha256", "section", "liquidus_c", "solidus_c", "outcome", "message"):
        findings.require(name in file.attrs, f"/: no attribute {name}")
    findings.require(file.attrs["schema_version"] == 3, "/: schema_version is not 3")
    findings.require(file["case"].shape == (), "/case is not a scalar")
    findings.require(isinstance(file["case"].asstr()[()], str), "/case is not a text")


def check_scale(findings, dataset, dimension, name):
    scales = [scale.name for scale in dataset.dims[dimension].values()]
    findings.require(scales == [name], f"{dataset.name}: scales of dimension {dimension}: {scales}")


def check_history(findings, file, fields):
    steps = file["history/step"].shape[0]
    in_plane = file.attrs["section"] != "quarter_slab"
    if not in_plane:  # the whole quarter, not per metre
        fields = {name.removesuffix("_per_m"): value for name, value in fields.items()}
    findings.require(set(file["history"]) == set(fields),
                     f"/history differs from the schema: {set(file['history']) ^ set(fields)}")
    for name, (kind, unit) in fields.items():
        if name in file["history"]:
            dataset = file["history"][name]
            findings.require(dataset.shape == (steps,), f"{dataset.name}: shape {dataset.shape}")
            check_array(findings, dataset, kind, unit if in_plane else unit.removesuffix("/m"))
            if name != "time_s":
                check_scale(findings, dataset, 0, "/history/time_s")
    findings.require((file["history/step"][()] == np.arange(1, steps + 1)).all(),
                     "/history/step has holes")
    findings.require((np.diff(file["history/time_s"][()]) > 0).all(), "/history/time_s goes back")
    monitors = file["monitors/name"].shape[0]
    coordinates = 3 if file.attrs["section"] == "quarter_slab" else 2
    for name, shape, unit in (("position_m", (monitors, coordinates), "m"),
                              ("displacement_m", (steps, monitors, coordinates), "m"),
                              ("temperature_c", (steps, monitors), "degC")):
        dataset = file["monitors"][name]
        findings.require(dataset.shape == shape, f"{dataset.name}: shape {dataset.shape}")
        check_array(findings, dataset, "f8", unit)
        if name != "position_m":
            check_scale(findings, dataset, 0, "/history/time_s")
        check_scale(findings, dataset, 0 if name == "position_m" else 1, "/monitors/name")


def frame_shapes(group):
    nodes, dimension = group["node_m"].shape
    elements, corners = group["element_node"].shape
    bottom = group["bottom_node"].shape[0]
    tensors = (elements, TENSOR_COMPONENTS[dimension])
    return {"node_m": (nodes, dimension), "element_node": (elements, corners),
            "temperature_c": (nodes,), "liquid_fraction": (nodes,),
            "displacement_m": (nodes, dimension), "stress_pa": tensors,
            "viscoplastic_strain": tensors, "bottom_node": (bottom,), "bottom_gap_m": (bottom,),
            "bottom_pressure_pa": (bottom,), "displacement_xyz_m": (nodes, 3),
            "solid_fraction": (nodes,), "von_mises_pa": (elements,),
            "contact_pressure_pa": (nodes,), "thermal_strain": (nodes,), "gap_m": (nodes,),
            "mean_stress_pa": (elements,), "principal_stress_pa": (elements, 3),
            "equivalent_viscoplastic_strain": (elements,),
            "tear_rate_per_s": (elements,), "tear_pressure_pa": (elements,)}


def check_frame(findings, group, fields):
    for name in ("step", "time_s", "cast_length_m", "metal_level_m"):
        findings.require(name in group.attrs, f"{group.name}: no attribute {name}")
    shapes = frame_shapes(group)
    findings.require(set(group) <= set(fields), f"{group.name}: {set(group) - set(fields)}")
    for name in group:
        dataset = group[name]
        findings.require(dataset.shape == shapes[name], f"{dataset.name}: shape {dataset.shape}")
        check_array(findings, dataset, *fields[name])
    nodes = shapes["node_m"][0]
    for name in ("element_node", "bottom_node"):
        values = group[name][()]
        if not findings.require(values.size == 0 or (values.min() >= 0 and values.max() < nodes),
                                f"{group.name}/{name}: numbers of nodes that are not there"):
            return
    if "bottom_pressure_pa" in group:
        findings.require((group["bottom_pressure_pa"][()] >= 0).all(),
                         f"{group.name}/bottom_pressure_pa: negative")
    if group["node_m"].shape[1] == 2:
        findings.require((polygon_areas(group) > 0).all(), f"{group.name}: elements turned over")


def polygon_areas(group):
    corners = group["node_m"][()][group["element_node"][()]]
    following = np.roll(corners, -1, axis=1)
    return 0.5 * (corners[..., 0] * following[..., 1] - corners[..., 1] * following[..., 0]).sum(1)


def check_frames(findings, file, fields):
    frames = sorted(file["frames"])
    findings.require(file["frames"].attrs["count"] == len(frames), "/frames: count is wrong")
    findings.require(frames == [f"{i:06d}" for i in range(len(frames))], "/frames has holes")
    for name in frames:
        check_frame(findings, file["frames"][name], fields)


def item_of(findings, parent, results, file):
    """The dataset a DataItem refers to, checked against the size and type it announces."""
    item = parent.find("DataItem")
    name, address = item.text.rsplit(":", 1)
    findings.require(name == results.name, f"sidecar refers to {name}")
    dataset = file[address]
    announced = tuple(int(word) for word in item.get("Dimensions").split())
    findings.require(dataset.shape == announced, f"sidecar: {address} is {dataset.shape}")
    findings.require({"Float": "f", "Int": "i"}[item.get("NumberType")] == dataset.dtype.kind
                     and int(item.get("Precision")) == dataset.dtype.itemsize,
                     f"sidecar: {address} is {dataset.dtype}")
    return dataset


def check_grid(findings, grid, results, file):
    topology, geometry = grid.find("Topology"), grid.find("Geometry")
    elements = item_of(findings, topology, results, file)
    nodes = item_of(findings, geometry, results, file)
    findings.require(int(topology.get("NumberOfElements")) == elements.shape[0],
                     "sidecar: number of elements")
    findings.require(NODES_OF_TOPOLOGY[topology.get("TopologyType")] == elements.shape[1],
                     "sidecar: topology type")
    findings.require({"XY": 2, "XYZ": 3}[geometry.get("GeometryType")] == nodes.shape[1],
                     "sidecar: geometry type")
    rows = {"Node": nodes.shape[0], "Cell": elements.shape[0]}
    for attribute in grid.findall("Attribute"):
        dataset = item_of(findings, attribute, results, file)
        findings.require(dataset.shape[0] == rows[attribute.get("Center")],
                         f"sidecar: centre of {attribute.get('Name')}")
    group = nodes.parent
    findings.require(float(grid.find("Time").get("Value")) == group.attrs["time_s"],
                     f"sidecar: time of {group.name}")


def check_sidecar(findings, results, file):
    root = xml.parse(results.with_suffix(".xdmf")).getroot()
    collection = root.find("Domain/Grid")
    findings.require(root.get("Version") == "3.0" and collection.get("CollectionType") == "Temporal",
                     "sidecar: not a temporal collection of XDMF 3")
    grids = collection.findall("Grid")
    findings.require(len(grids) == len(file["frames"]), "sidecar: number of frames")
    for grid in grids:
        check_grid(findings, grid, results, file)


def check_h5dump(findings, results):
    dump = subprocess.run(["h5dump", "-H", str(results)], capture_output=True, text=True,
                          check=False)
    findings.require(dump.returncode == 0 and 'GROUP "history"' in dump.stdout,
                     f"h5dump: {dump.stderr.strip()}")


def check(results):
    findings = Findings()
    history, frame = schema_datasets()
    findings.require(len(history) >= 20 and len(frame) >= 10, "the tables of SCHEMA.md are not found")
    with h5py.File(results, "r") as file:
        check_root(findings, file)
        check_history(findings, file, history)
        check_frames(findings, file, frame)
        check_sidecar(findings, results, file)
    check_h5dump(findings, results)
    return findings


def main():
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    differs = False
    for name in sys.argv[1:]:
        findings = check(pathlib.Path(name))
        differs = differs or bool(findings)
        print(f"{name}: " + ("as SCHEMA.md says" if not findings else "\n  ".join(["", *findings])))
    return 1 if differs else 0


if __name__ == "__main__":
    sys.exit(main())
