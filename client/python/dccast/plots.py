"""Charts with matplotlib."""
from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from dccast import errors

if TYPE_CHECKING:
    from dccast.runs import Band
    from dccast.v1 import judgement_pb2


def plot_curl(bands: Mapping[str, Band], axes: Any = None, against: str = "time_s") -> Any:
    """Draws curls by label, each with its band, in mm. Returns the matplotlib axes.

    @param against  "time_s" or "cast_length_m"

    >>> service = dccast.connect()
    >>> runs = {f"{v} mm/min": service.query("start-2d-thickness", quality="draft", time__end="20 s",
    ...                                      schedule__casting_speed=f"{v} mm/min") for v in (40, 60)}
    >>> axes = dccast.plot_curl({label: run.band() for label, run in runs.items()})
    >>> axes.get_ylabel()
    'curl [mm]'
    """
    axes = _axes() if axes is None else axes
    scale = {"time_s": 1.0, "cast_length_m": 1e3}[against]
    for label, band in bands.items():
        at = scale * getattr(band, against)
        line, = axes.plot(at, 1e3 * band.curl_m, label=label)
        axes.fill_between(at, 1e3 * (band.curl_m - band.lower_error_m),
                          1e3 * (band.curl_m + band.upper_error_m),
                          color=line.get_color(), alpha=0.2, linewidth=0)
    axes.set_xlabel({"time_s": "time [s]", "cast_length_m": "cast length [mm]"}[against])
    axes.set_ylabel("curl [mm]")
    _add_legend(axes)
    return axes


def plot_chart(chart: judgement_pb2.Chart, axes: Any = None) -> Any:
    """Draws a chart of a judgement in the units of a plant. Returns the matplotlib axes.

    @param chart  one of `Judgement.charts`

    >>> service = dccast.connect()
    >>> runs = [service.query("start-2d-thickness", quality="draft", time__end="20 s",
    ...                       schedule__casting_speed=f"{speed} mm/min") for speed in (40, 80)]
    >>> dccast.plot_chart(service.compare(*runs).charts[0]).get_xlabel()
    'cast length [mm]'
    """
    axes = _axes() if axes is None else axes
    (x_scale, x_unit), (y_scale, y_unit) = (_drawn_unit(axis.unit) for axis in (chart.x, chart.y))

    for line in chart.lines:
        at = [x_scale * x for x in line.x]
        drawn, = axes.plot(at, [y_scale * y for y in line.y], "o" if line.is_dotted else "-", label=line.name)
        if line.low:
            axes.fill_between(at, [y_scale * y for y in line.low], [y_scale * y for y in line.high],
                              color=drawn.get_color(), alpha=0.2, linewidth=0)
    if chart.HasField("region"):
        axes.axhspan(y_scale * chart.region.low, y_scale * chart.region.high, color="grey", alpha=0.15,
                     linewidth=0, label=chart.region.name)

    axes.set_xlabel(f"{chart.x.quantity} [{x_unit}]")
    axes.set_ylabel(f"{chart.y.quantity} [{y_unit}]")
    _add_legend(axes)
    return axes


def _axes() -> Any:
    try:
        from matplotlib import pyplot
    except ImportError:
        raise errors.missing("matplotlib", "apt install python3-matplotlib") from None
    return pyplot.subplots(layout="constrained")[1]


def _add_legend(axes: Any) -> None:
    """Above the axes: inside it would cover curves and bands."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)


def _drawn_unit(unit: str) -> tuple[float, str]:
    """The unit of a plant, by the table in judgement.proto, and the factor to it."""
    from dccast.v1 import judgement_pb2, options_pb2
    table = judgement_pb2.DESCRIPTOR.GetOptions().Extensions[options_pb2.plant_unit]
    return next(((row.factor, row.name) for row in table if row.si == unit), (1.0, unit))
