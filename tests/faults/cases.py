"""The castings that the faults befall: small ones of the real solver, and those of the fake worker."""
import functools
import json
import os
import re
import shutil
import subprocess
import tempfile

from dccast.v1 import service_pb2
from support import BIN, Client, Daemon, fake_case

REAL = "dccast-worker"
FAKE = "dccast-worker-fake"
SHIPPED = os.path.join(os.path.dirname(os.path.abspath(__file__)),
                       "..", "..", "cases", "start-2d-thickness.toml")

# The shipped start-up case on few cells: 280 steps in half a second, every part of the solver used.
# Element and keys are known to earlier versions too: load.py compares.
COARSE = ((r"(?s)^\[mesh\].*?(?=^\[)",
           '[mesh]\nelement = "q1"\ncolumns = 8\nrows = 6\nside_cell = "10 mm"\n'
           'bottom_cell = "10 mm"\ngrowth_cell = "15 mm"\n\n'),
          (r"^every_steps = .*$", "every_steps = 20"))

# Solved so loosely that the run's own check of the support fails on the way.
LOOSE = ((r"^algorithm = .*$", 'algorithm = "newton"\ntolerance = 3e-3'),)


# The same on a mesh file, of a block that stands.
OWN_MESH = ((r"(?s)^\[mesh\].*?(?=^\[)", '[mesh]\nfile = "slab.msh"\ngrowth = false\n\n'),
            (r"^casting_speed = .*$", 'casting_speed = "0 mm/min"'),
            (r"^end = .*$", 'end = "40 s"\nstep = "0.5 s"'))
PAGE = os.path.join(os.path.dirname(SHIPPED), "..", "docs", "own-mesh.md")


def edited(text, changes):
    """The text with each pattern replaced. Raises ValueError for a pattern that is not there."""
    for pattern, replacement in changes:
        text, count = re.subn(pattern, replacement, text, flags=re.M)
        if count == 0:
            raise ValueError(f"{SHIPPED} has no line {pattern}")
    return text


def read_by_the_client(text, **files):
    """The complete Case that the command line client makes of a case file, with the files it names."""
    folder = tempfile.mkdtemp(prefix="dccast-case-")
    daemon = Daemon(folder, FAKE).start()
    client = Client(daemon.address)
    try:
        for name, content in files.items():
            with open(os.path.join(folder, f"{name}.msh"), "wb") as file:
                file.write(content)
        path = os.path.join(folder, "case.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        ended = subprocess.run([os.path.join(BIN, "dccast"), "--server", daemon.address, "submit",
                                "--json", path], capture_output=True, text=True, timeout=60,
                               check=False)
        if ended.returncode != 0:
            raise RuntimeError(ended.stderr)
        request = service_pb2.QueryResultRequest(id=json.loads(ended.stdout)["id"])
        return client.stub.QueryResult(request, timeout=20).case
    finally:
        client.close()
        daemon.kill()
        shutil.rmtree(folder, ignore_errors=True)


def shipped(*changes):
    with open(SHIPPED, encoding="utf-8") as file:
        return edited(file.read(), changes)


@functools.cache
def coarse():
    """A run that succeeds."""
    return read_by_the_client(shipped(*COARSE))


@functools.cache
def failing_check():
    """A run that ends, but one of whose own checks failed on the way."""
    return read_by_the_client(shipped(*COARSE, *LOOSE))


@functools.cache
def own_mesh():
    """A block of metal that cools, on a mesh of one's own. Returns its case and the file "slab.msh"."""
    with open(PAGE, encoding="utf-8") as file:
        writers = {}
        exec(re.search(r"```python\n(.*?)```", file.read(), re.DOTALL)[1], writers)
    with tempfile.NamedTemporaryFile() as file:
        writers["write_section"](file.name, 0.28, 0.10, 0.02)
        mesh = file.read()
    return read_by_the_client(shipped(*OWN_MESH), slab=mesh), mesh


def fake(title):
    """What dccast-worker-fake does with the title: tests/support/fake_casting/README.md."""
    return fake_case(title)


def without_pauses(case):
    """A casting with the same results that takes less time."""
    quick = type(case)()
    quick.CopyFrom(case)
    quick.title = re.sub(r" ?(sleep_ms|wait_at)=\d+", "", case.title)
    return quick
