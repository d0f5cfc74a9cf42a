#!/usr/bin/python3
"""Breaks the real programs on purpose and counts what was lost. Exit code 0: nothing.

    tests/faults/run.py --short                    what ./tests/run does, in parts
    tests/faults/run.py --long --table             renews the table of tests/faults/RESULTS.md
    tests/faults/run.py --long --only kill-worker --seed 7
    tests/faults/run.py --soak 8                   eight hours of everything; is the daemon growing?
"""
import argparse
import importlib
import os
import signal
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
BUILD = os.path.join(ROOT, "build", "release")
FAMILIES = ("kills", "hangs", "disk", "damage", "store", "clients", "clock", "studies",
            "slurm", "access", "hostile", "followers", "web", "browsers", "hostile_browsers")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--short", action="store_true", help="few tries of each fault (default)")
    form.add_argument("--long", action="store_true", help="200 kills, dozens of each other fault")
    form.add_argument("--soak", type=float, metavar="HOURS",
                      help="castings, sweeps, queries and kills, round after round")
    parser.add_argument("--only", action="append", default=[], metavar="NAME",
                        help="a fault or a family of faults; may be repeated")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bin", default=os.environ.get("DCCAST_BIN", os.path.join(BUILD, "bin")),
                        help="folder of dccastd, dccast, dccast-worker and dccast-worker-fake")
    parser.add_argument("--table", nargs="?", const=os.path.join(ROOT, "tests", "faults", "RESULTS.md"),
                        metavar="FILE", help="renews the rows of what is tried in the table of FILE; "
                        "without FILE: tests/faults/RESULTS.md")
    parser.add_argument("--list", action="store_true", help="names the faults and does nothing")
    return parser.parse_args()


def set_up_imports(programs):
    """What tests/service shares, and Python's code of the .proto files beside the programs."""
    os.environ["DCCAST_BIN"] = os.path.abspath(programs)
    beside = os.path.join(os.path.dirname(os.path.abspath(programs)), "python")
    built = beside if os.path.isdir(beside) else os.path.join(BUILD, "python")
    sys.path += [os.path.join(ROOT, "tests", "service"), os.path.join(ROOT, "tests", "support"), built]


def faults_of(family):
    from fault import Fault
    module = importlib.import_module(family)
    return [thing for thing in vars(module).values()
            if isinstance(thing, type) and issubclass(thing, Fault)
            and thing.__module__ == family and "attempt" in dir(thing) and thing.__doc__
            and not thing.__subclasses__()]


def chosen(only):
    unknown = set(only)
    for family in FAMILIES:
        for fault in faults_of(family):
            if not only or family in only or fault.name() in only:
                unknown -= {family, fault.name()}
                yield family, fault
    if unknown:
        sys.exit(f"run.py: no such fault: {', '.join(sorted(unknown))}; see --list")


def tried(fault, seed, long):
    """Tries a fault as often as the form asks, or as its time permits."""
    from oracle import Count
    from scene import chance_of
    row = Count()
    wanted = fault.long if long else fault.short
    end = time.monotonic() + fault.seconds * (8 if long else 1)
    number = 0
    while row.tried < wanted and (number == 0 or time.monotonic() < end):
        number += 1
        before = row.tried
        try:
            row.add(fault().attempt(chance_of(seed, fault.name(), number), wanted - row.tried))
        except Exception as error:  # whatever it is, this try did not end well
            row.add(Count(tried=1))
            row.found("wrong", f"try {number}: {type(error).__name__}: {error}")
        if row.tried == before:
            break  # cannot be tried here; the notes say why
    return row


def show(fault, options, order):
    """Tries a fault, says what came of it, and writes its row. True: nothing was lost."""
    from table import markdown, write_row
    begin = time.monotonic()
    count = tried(fault, options.seed, options.long)
    seconds = time.monotonic() - begin
    print(f"{fault.name():28} tried {count.tried:4}  lost {count.lost:3}  duplicated "
          f"{count.duplicated:3}  wrong {count.wrong:3}  {seconds:6.1f} s", flush=True)
    for unit, value in count.figures.items():
        print(f"    {value:.3g} {unit}")
    for note in count.notes[:8]:
        print(f"    {note}", flush=True)
    if options.table and count.tried:
        write_row(options.table, fault.name(), markdown(fault, count, seconds, options), order, options)
    return count.clean()


def main():
    options = arguments()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(130))  # so that everything is cleared away
    set_up_imports(options.bin)
    if options.soak:
        from soak import Soak
        Soak.hours, options.table = options.soak, None
        return 0 if show(Soak, options, []) else 1
    order = [fault.name() for _, fault in chosen([])]
    clean = True
    for family, fault in chosen(options.only):
        if options.list:
            print(f"{fault.name():28} {family:8} {fault.says()}")
            continue
        clean = show(fault, options, order) and clean
    return 0 if clean else 1


if __name__ == "__main__":
    sys.exit(main())
