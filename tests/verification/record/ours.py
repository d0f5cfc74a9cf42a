#!/usr/bin/python3
"""Predicts what dccast can of the record, and seals it: about ten minutes of processor.

    ours.py BIN OUTPUT        BIN: folder of dccast, dccastd, dccast-worker and dccast-billet

Curls: drafts over the ranges of the data to which a start responds most (docs/uncertainty.md), by the response
surface of `dccast uncertainty`. Billets: an ensemble of `dccast-billet`. answers.json has what the model says in words,
and the quantiles of figures that take hours and are taken over from the pages that the words name.
"""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests/record"), str(ROOT / "tests/benchmark")]
import record  # noqa: E402
from calculix_block import Service  # noqa: E402

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
MEMBERS = 16  # of an ensemble of billets
RUNS = 10  # drafts of a start
WATER = ("cooling.water.critical_heat_flux", "cooling.water.wetting.rewetting_rise",
         "cooling.water.wetting.rewetting_saturated", "cooling.bottom_block.gap_coefficient",
         "cooling.bottom_block.wet_coefficient")
STARTS = {  # entry: measurement, case, monitor
    "slab-paper-curl": ("corner-250s", "start-3d-paper", "corner"),
    "slab-aa3104-curl": ("plant-mean", "start-3d-aa3104", "plant"),
    "slab-1860x510-aa1201-curl": ("curl", "start-3d-aa1050-1860x510", "plant"),
}


def quantile(values, level):
    """Linear between the values. @param values  ascending"""
    place = level * (len(values) - 1)
    low = math.floor(place)
    high = min(low + 1, len(values) - 1)
    return values[low] + (place - low) * (values[high] - values[low])


def billets(folder):
    """Predictions of the depths of both billets."""
    answer = json.loads(subprocess.run([folder / "dccast-billet", "ensemble", str(MEMBERS)], check=True,
                                       capture_output=True, text=True).stdout)
    level_above_ring = {"billet-al6cu-450": 0.0, "billet-aa6008-155": 0.1}  # [m]
    for entry, ensemble in answer.items():
        for figure, depths in zip(record.entries()[entry]["measured"], zip(*ensemble), strict=True):
            if None in depths:
                continue  # not every member reaches this temperature
            ordered = sorted(depth - level_above_ring[entry] for depth in depths)
            yield entry, figure["name"], {str(level): round(quantile(ordered, level), 5) for level in LEVELS}


def starts(service):
    """Predictions of the curls of starts."""
    for entry, (measurement, case, monitor) in STARTS.items():
        words = [word for key in WATER for word in ("--only", key)]
        answer = json.loads(service.client("uncertainty", str(ROOT / f"cases/{case}.toml"), *words, "--runs", str(RUNS),
                                           "--point", monitor, "--json"))
        spread = answer["spread"]
        yield entry, measurement, {level: round(1e3 * spread[key][-1], 2) for level, key in (
            ("0.05", "low_m"), ("0.5", "median_m"), ("0.95", "high_m"))}


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    folder, output = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory(prefix="dccast-record-") as scratch:
        service = Service(folder.parent, scratch)
        try:
            version = service.client("--version").split()[-1]
            made = [{"entry": entry, "measurement": measurement, "quantiles": quantiles}
                    for part in (billets(folder), starts(service)) for entry, measurement, quantiles in part]
        finally:
            service.stop()
    known = json.loads(pathlib.Path(__file__).with_name("answers.json").read_text("utf-8"))
    made += known["taken_over"]
    lines = ",\n".join("  " + json.dumps(item) for item in made)
    output.write_text('{"code": "dccast", "version": "%s",\n "predictions": [\n%s],\n "answers": %s}\n' % (
        version, lines, json.dumps(known["answers"], indent=2, ensure_ascii=False)), "utf-8")
    print(f"{output} {record.seal(output)}")


if __name__ == "__main__":
    main()
