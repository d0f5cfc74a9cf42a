"""Figures as people read them."""
from __future__ import annotations

import math


def with_error(value: float, error: float | None = None, unit: str = "",
               most_decimals: int = 15) -> str:
    """A value with as many digits as its error, which has two; without an error, three digits.

    >>> with_error(58.41, 11.68, "mm"), with_error(5.2519, 0.2101, "mm"), with_error(-0.001, 0.2)
    ('58 ± 12 mm', '5.25 ± 0.21 mm', '0.00 ± 0.20')
    >>> with_error(35.456, unit="mm"), with_error(0.0)
    ('35.5 mm', '0')
    """
    known = error is not None and math.isfinite(error) and error > 0.0
    leading = abs(error if known and error is not None else value)
    if not math.isfinite(value):
        return "-"
    digits = 2 if known else 3
    decimals = 0 if leading == 0.0 else digits - 1 - math.floor(math.log10(leading))
    # 0.996 rounds to 1.0, which has one decimal less.
    if leading != 0.0 and round(leading, decimals) >= 10.0 ** (digits - decimals):
        decimals -= 1
    decimals = min(decimals, most_decimals)
    shown = f"{_rounded(value, decimals):.{max(decimals, 0)}f}"
    if known and error is not None:
        shown += f" ± {_rounded(error, decimals):.{max(decimals, 0)}f}"
    return f"{shown} {unit}".rstrip()


def millimetres(metres: float, lower_m: float = math.nan, upper_m: float = math.nan) -> str:
    """A curl with its errors, NaN where they are not known: to hundredths at most, as none is known better.

    >>> millimetres(5.2519e-3, 0.2101e-3, 0.2101e-3), millimetres(1.2e-9)
    ('5.25 ± 0.21 mm', '0.00 mm')
    >>> millimetres(35.46e-3, 0.0, 4.96e-3)
    '35.5, -0 +5.0 mm'
    >>> millimetres(0.041e-3, 0.002e-3, 0.008e-3)
    '0.04, -0 +0.01 mm'
    """
    if not max(lower_m, upper_m) > 0.0:
        return f"{_rounded(1e3 * metres, 2):.2f} mm"
    if lower_m == upper_m:
        return with_error(1e3 * metres, 1e3 * upper_m, "mm", 2)
    curl, upper = with_error(1e3 * metres, 1e3 * max(lower_m, upper_m), "", 2).split(" ± ")
    decimals = len(upper.partition(".")[2])
    shown = [f"{1e3 * side:.{decimals}f}" for side in (lower_m, upper_m)]
    lower, upper = ("0" if float(side) == 0.0 else side for side in shown)
    return f"{curl}, -{lower} +{upper} mm"


def _rounded(value: float, decimals: int) -> float:
    """Rounded, and never -0."""
    return round(value, decimals) + 0.0


def span(first: float, last: float, unit: str) -> str:
    """"0 to 145 s"."""
    return f"{first:.4g} to {last:.4g} {unit}"
