"""Charts with matplotlib."""
from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from dccast import errors

if TYPE_CHECKING:
    from dccast.runs import Band


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
    if axes is None:
        try:
            from matplotlib import pyplot
        except ImportError:
            raise errors.missing("matplotlib", "apt install python3-matplotlib") from None
        axes = pyplot.subplots(layout="constrained")[1]
    scale = {"time_s": 1.0, "cast_length_m": 1e3}[against]
    for label, band in bands.items():
        at = scale * getattr(band, against)
        line, = axes.plot(at, 1e3 * band.curl_m, label=label)
        axes.fill_between(at, 1e3 * (band.curl_m - band.lower_error_m),
                          1e3 * (band.curl_m + band.upper_error_m),
                          color=line.get_color(), alpha=0.2, linewidth=0)
    axes.set_xlabel({"time_s": "time [s]", "cast_length_m": "cast length [mm]"}[against])
    axes.set_ylabel("curl [mm]")
    # Above the axes: inside it would cover curves and bands.
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)
    return axes
