"""Runs of a study for dccast-line-posterior: what castings of a line teach, on hidden plants.

    line_posterior.py RUNS.csv [--study ID] [--runs 128] [--case start-3d-aa3104]

Begins an uncertainty study to 250 s on the server of the command line client, or takes one up, and writes
its runs: danger, curl of the judged monitor in m, and the place on each axis, 0 to 1. Then

    dccast-line-posterior RUNS.csv [SHARE]

prints the table of docs/lines.md.
"""
import argparse
import math

import dccast
from dccast.v1 import job_pb2


def main():
    words = argparse.ArgumentParser()
    words.add_argument("output")
    words.add_argument("--study")
    words.add_argument("--runs", type=int, default=128)
    words.add_argument("--case", default="start-3d-aa3104")
    given = words.parse_args()
    service = dccast.connect(timeout_s=600)
    study = (service.study(given.study) if given.study else
             service.uncertainty(given.case, runs=given.runs, time__end="250 s"))
    print("study", study.id, flush=True)
    study.wait(check=False)

    result = study.evaluate()
    name = result.judged_monitor or "corner"
    monitor = list(result.monitors).index(name)
    numbers = [list(run.numbers) for run in result.runs]
    low, high = [list(map(end, zip(*numbers))) for end in (min, max)]
    dangers = 0
    with open(given.output, "w", encoding="ascii") as file:
        for run, places in zip(result.runs, numbers):
            ended = run.state in (job_pb2.SUCCEEDED, job_pb2.FAILED)
            if not ended:
                continue
            valid = run.state == job_pb2.SUCCEEDED and not run.beyond_validity
            curl = run.end_curl_m[monitor] if valid and len(run.end_curl_m) > monitor else math.nan
            danger = math.isnan(curl) or any(finding.severity == job_pb2.Finding.DANGER
                                             for finding in run.findings)
            dangers += danger
            row = [int(danger), curl] + [(x - a) / (b - a) if b > a else 0.5
                                         for x, a, b in zip(places, low, high)]
            file.write(",".join(map(str, row)) + "\n")
    print(f"{dangers} of {len(numbers)} runs with a danger, monitor {name}")


if __name__ == "__main__":
    main()
