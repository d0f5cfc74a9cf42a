"""Stored fields of a run: nodes, cells, temperature and displacement at an instant."""
from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from dccast import errors
from dccast.runs import Floats
from dccast.text import span
from dccast.transport import Transport
from dccast.v1 import service_pb2

CELLS = {(2, 3): "triangle", (2, 4): "quad", (3, 4): "tetra", (3, 8): "hexahedron"}


class Frame:
    """The fields at one instant."""

    def __init__(self, message: service_pb2.Frame) -> None:
        self.message = message

    def __repr__(self) -> str:
        return (f"<dccast.Frame at {self.time_s:.4g} s, {1e3 * self.cast_length_m:.4g} mm cast, "
                f"{len(self.message.temperature_c)} nodes>")

    @property
    def time_s(self) -> float:
        """Of the case: zero is when the bottom block starts to move."""
        return float(self.message.time_s)

    @property
    def cast_length_m(self) -> float:
        """How far the bottom block has moved."""
        return float(self.message.cast_length_m)

    @property
    def points_m(self) -> Floats:
        """(node, 3) in the undeformed slab; of a section z is 0."""
        return self._in_space(self.message.node_m)

    @property
    def displacement_m(self) -> Floats:
        """(node, 3)"""
        return self._in_space(self.message.displacement_m)

    @property
    def temperature_c(self) -> Floats:
        """(node)"""
        return np.array(self.message.temperature_c)

    @property
    def cells(self) -> npt.NDArray[np.int64]:
        """(cell, its nodes), in the order of VTK."""
        return np.array(self.message.element_node, dtype=np.int64).reshape(
            -1, self.message.nodes_per_element)

    def to_meshio(self) -> Any:
        """As a meshio.Mesh, which writes VTU for ParaView: frame.to_meshio().write("end.vtu")."""
        try:
            import meshio
        except ImportError:
            raise errors.missing("meshio", "apt install python3-meshio") from None
        kind = CELLS[self.message.dimension, self.message.nodes_per_element]
        return meshio.Mesh(self.points_m, [(kind, self.cells)], point_data={
            "temperature_c": self.temperature_c, "displacement_m": self.displacement_m})

    def to_pyvista(self) -> Any:
        """As a pyvista.UnstructuredGrid."""
        try:
            import pyvista
        except ImportError:
            raise errors.missing("pyvista", "it is not in Debian 12; pip install pyvista") from None
        return pyvista.from_meshio(self.to_meshio())

    def _in_space(self, numbers: Sequence[float]) -> Floats:
        plane = np.array(numbers).reshape(-1, self.message.dimension)
        space: Floats = np.zeros((len(plane), 3))
        space[:, :self.message.dimension] = plane
        return space


class Frames(Sequence[Frame]):
    """The frames of a job, each fetched when it is asked for.

    >>> job = dccast.connect().submit("start-2d-thickness", quality="draft", time__end="20 s").wait()
    >>> job.frames[-1].time_s, len(job.frames) == len(job.frames.times_s)
    (20.0, True)

    A frame beyond 4 MB is refused (RESOURCE_EXHAUSTED): Job.fetch has it in results.h5.
    """

    def __init__(self, transport: Transport, job: str) -> None:
        self._transport, self._job = transport, job

    def __repr__(self) -> str:
        return f"<dccast.Frames {len(self)}, {span(self.times_s[0], self.times_s[-1], 's')}>" \
            if len(self) else "<dccast.Frames 0>"

    @functools.cached_property
    def times_s(self) -> list[float]:
        """Of every stored frame."""
        return list(self._asked(0).frame_time_s)

    def __len__(self) -> int:
        return len(self.times_s)

    @overload
    def __getitem__(self, index: int) -> Frame: ...

    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...

    def __getitem__(self, index: int | slice) -> Frame | list[Frame]:
        numbers = range(len(self))[index]
        if isinstance(numbers, range):
            return [self[number] for number in numbers]
        return Frame(self._asked(numbers + 1).frame)

    def _asked(self, number: int) -> service_pb2.QueryResultResponse:
        answer: service_pb2.QueryResultResponse = self._transport.call(
            "QueryResult", service_pb2.QueryResultRequest(id=self._job, frame=True, page_size=1,
                                                          frame_number=number))
        return answer
