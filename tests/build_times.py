#!/usr/bin/python3
"""Where the time of a build went: seconds of each part of the project, from ninja's log.

    tests/build_times.py [BUILD_FOLDER] [--files N]

A step's seconds run from its start to its end on the clock, so that their sum is processor time only
where nothing else runs and no compiler cache answers. Of a target built several times the last counts.
"""
import argparse
import collections
import pathlib
import re


def steps_of(log):
    """Output -> seconds of the last time it was made."""
    steps = {}
    for line in log.read_text().splitlines():
        fields = line.split("\t")
        if not line.startswith("#") and len(fields) >= 4:
            steps[fields[3]] = (int(fields[1]) - int(fields[0])) / 1000.0
    return steps


def part_of(output):
    """ "client", "server/jobs", "core", "generated messages", ...; None for what is no step of ours."""
    if output.endswith(".gch"):
        return "precompiled headers"
    if not output.endswith(".o"):
        return "linking" if re.search(r"\.(a|so)$|^bin/", output) else None
    if ".pb.cc" in output:
        return "generated messages"
    folder = output.split("/CMakeFiles/")[0]
    parts = folder.split("/")
    return "/".join(parts[:2]) if parts[0] in ("server", "tests") else parts[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", nargs="?", default="build/release", type=pathlib.Path)
    parser.add_argument("--files", type=int, default=10, help="number of the slowest files")
    arguments = parser.parse_args()
    steps = steps_of(arguments.build / ".ninja_log")
    seconds, files = collections.Counter(), collections.Counter()
    for output, taken in steps.items():
        part = part_of(output)
        if part:
            seconds[part] += taken
            files[part] += 1
    print("| part | steps | s |\n|---|---|---|")
    for part, taken in seconds.most_common():
        print(f"| {part} | {files[part]} | {taken:.0f} |")
    print(f"| all | {sum(files.values())} | {sum(seconds.values()):.0f} |")
    slowest = sorted((taken, output) for output, taken in steps.items() if part_of(output))
    for taken, output in reversed(slowest[-arguments.files:] if arguments.files else []):
        print(f"{taken:6.1f} s  {re.sub(r'CMakeFiles/[^/]*[.]dir/', '', output)}")


if __name__ == "__main__":
    main()
