"""Figures as people read them."""
from __future__ import annotations

import math
import sys


def millimetres(metres: float, lower_m: float = math.nan, upper_m: float = math.nan) -> str:
    """A curl with its errors, NaN where they are not known: with as many decimals as the larger of them has
    with two digits, to hundredths at most, as none is known better.

    >>> millimetres(5.2519e-3, 0.2101e-3, 0.2101e-3), millimetres(1.2e-9)
    ('5.25 ± 0.21 mm', '0.00 mm')
    """
    decimals = _decimals(1e3 * max(lower_m, upper_m))
    curl, lower, upper = (_fixed(1e3 * figure, decimals) for figure in (metres, lower_m, upper_m))
    if not math.isfinite(upper_m):
        return f"{curl} mm"
    if lower_m == upper_m:
        return f"{curl} ± {upper} mm"
    lower, upper = ("0" if float(side) == 0.0 else side for side in (lower, upper))
    return f"{curl}, -{lower} +{upper} mm"


def _decimals(error_mm: float) -> int:
    hundredths = 2
    if not 0.0 < error_mm < math.inf:
        return hundredths
    decimals = 1 - math.floor(math.log10(error_mm))
    # 0.996 rounds to 1.0, which has one decimal less.
    if round(error_mm, decimals) >= 10.0 ** (2 - decimals):
        decimals -= 1
    return min(max(decimals, 0), hundredths)


def _fixed(value: float, decimals: int) -> str:
    """Zero has no sign."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}"


def span(first: float, last: float, unit: str) -> str:
    """"0 to 145 s"."""
    return f"{first:.4g} to {last:.4g} {unit}"


def show_progress(share: float, words: str, last: bool = False) -> None:
    """Draws a bar on standard error, over the one before.

    @param last  leave it there
    """
    width = 30
    done = round(width * min(max(share, 0.0), 1.0))
    line = f"[{'#' * done}{'.' * (width - done)}] {words}"
    print(f"\r{line[:100]:100}", end="\n" if last else "", file=sys.stderr, flush=True)
