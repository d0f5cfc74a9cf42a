#!/usr/bin/python3
"""Pages of the API from the headers (Doxygen) and from the contract (protoc).

Usage: make_pages.py --output FOLDER [--check FILE]
  --check FILE   ends with 1 where a room has more public symbols without documentation than FILE states, or
                 where Doxygen finds a fault in a docstring
Needs doxygen, protobuf-compiler and python3-protobuf: deploy/install_packages build test nightly. Ends with 77 without them.
"""
import argparse
import collections
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ROOMS = ("core", "proto", "server", "client")
CONTRACT = "contract"
MISSING = 77


def run_doxygen(folder, log):
    settings = (HERE / "Doxyfile").read_text(encoding="utf-8")
    settings += f"\nINPUT = {' '.join(ROOMS)}\nOUTPUT_DIRECTORY = \"{folder}\"\nWARN_LOGFILE = \"{log}\"\n"
    subprocess.run(["doxygen", "-"], input=settings, text=True, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def names_a_commented_parameter(warning):
    """Whether it is about a name that stands in a comment, as of a virtual function that does not use it."""
    named = re.match(r"([^ ]+\.hpp):\d+: .*argument '(\w+)' of command @param is not found", warning)
    return named is not None and f"/*{named[2]}*/" in (ROOT / named[1]).read_text(encoding="utf-8")


def sorted_warnings(log):
    """Symbols without documentation by room, and all that Doxygen says besides."""
    undocumented, faults = collections.defaultdict(set), set()
    for line in log.read_text(encoding="utf-8").splitlines():
        place = line.removeprefix(f"{ROOT}/")
        if "is not documented" in line:
            undocumented[place.split("/")[0]].add(place)
        elif re.match(r"[^ ]+\.hpp:\d+: ", place) and not names_a_commented_parameter(place):
            faults.add(place)
    return undocumented, sorted(faults)


def stated_counts(file):
    rows = [line.split() for line in file.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return {room: int(count) for room, count in (row for row in rows if row)}


def write_index(folder, pages):
    links = "".join(f"<li><a href='contract/{page}'>{page.removesuffix('.html')}.proto</a></li>" for page in pages)
    (folder / "index.html").write_text(
        "<!doctype html><meta charset='utf-8'><title>API of dccast</title><h1>API of dccast</h1>"
        "<p><a href='headers/index.html'>Headers</a> of core, proto, server and client</p>"
        f"<p>The contract dccast.v1:</p><ul>{links}</ul>", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("--check", type=pathlib.Path)
    arguments = parser.parse_args()
    lacking = [program for program in ("doxygen", "protoc") if not shutil.which(program)]
    if lacking:
        print(f"{' and '.join(lacking)} not found: deploy/install_packages build nightly", file=sys.stderr)
        return MISSING

    from contract import write_contract  # needs python3-protobuf

    folder = arguments.output.resolve()
    (folder / "contract").mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        log = pathlib.Path(scratch) / "warnings"
        run_doxygen(folder, log)
        undocumented, faults = sorted_warnings(log)
        pages, silent = write_contract(ROOT / "proto", folder / "contract", pathlib.Path(scratch))
    undocumented[CONTRACT] = set(silent)
    write_index(folder, pages)

    report = [line for room in (*ROOMS, CONTRACT) for line in sorted(undocumented[room])]
    (folder / "symbols.txt").write_text("\n".join(report) + "\n", encoding="utf-8")
    for room in (*ROOMS, CONTRACT):
        print(f"{room}: {len(undocumented[room])} symbols without documentation")
    for fault in faults:
        print(fault)
    if arguments.check is None:
        return 0

    stated = stated_counts(arguments.check)
    too_many = [room for room in (*ROOMS, CONTRACT) if len(undocumented[room]) > stated.get(room, 0)]
    for room in too_many:
        print(f"{room}: more than the {stated.get(room, 0)} that {arguments.check.name} states; "
              f"{folder}/symbols.txt lists them", file=sys.stderr)
    return 1 if too_many or faults else 0


if __name__ == "__main__":
    sys.exit(main())
