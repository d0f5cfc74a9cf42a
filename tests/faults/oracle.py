"""What must be true after every fault, whatever it was."""
import contextlib
import dataclasses
import functools
import hashlib
import io
import random
import time

import grpc
import h5py

from cases import without_pauses
from dccast.v1 import case_pb2, job_pb2
from scene import Scene
from support import TERMINAL
from waiting import until

RESULTS = "results.h5"


@dataclasses.dataclass
class Count:
    """One row of the table, or what one try adds to it."""
    tried: int = 0
    lost: int = 0        # jobs that are gone, or miss a step or a result
    duplicated: int = 0  # jobs or events that are there twice
    wrong: int = 0       # another state, result or history than undisturbed; or a service that failed
    notes: list = dataclasses.field(default_factory=list)
    figures: dict = dataclasses.field(default_factory=dict)  # the largest of each, by its unit

    def measured(self, unit, value):
        self.figures[unit] = max(value, self.figures.get(unit, 0))

    def add(self, other):
        self.tried += other.tried
        self.lost += other.lost
        self.duplicated += other.duplicated
        self.wrong += other.wrong
        self.notes += other.notes
        for unit, value in other.figures.items():
            self.measured(unit, value)

    def found(self, kind, note):
        setattr(self, kind, getattr(self, kind) + 1)
        self.notes.append(f"{kind}: {note}")

    def clean(self):
        return self.lost == self.duplicated == self.wrong == 0


@dataclasses.dataclass
class Undisturbed:
    """What a case comes to when nothing happens to it."""
    state: int
    failure: bytes
    steps: list     # serialised reports, without the solver's seconds
    files: dict     # name of an artifact -> SHA-256
    content: str    # digest of what results.h5 says, but for the digest of its case
    seconds: float  # from submission to end


def physics(step):
    """A report without what the clock says, in bytes, so that every bit counts. The error of a curl is left
    out: it is known of a case, and not of the same case with a file, whose twin has none."""
    step.ClearField("solver_s")
    step.ClearField("process_s")
    for monitor in step.monitors:
        monitor.ClearField("curl_lower_error_m")
        monitor.ClearField("curl_upper_error_m")
    return step.SerializeToString(deterministic=True)


def all_steps(client, job_id):
    """The step history by QueryResult, page by page."""
    steps, token = [], ""
    while True:
        answer = client.ask("QueryResult", id=job_id, page_token=token)
        steps += answer.steps
        token = answer.next_page_token
        if not token:
            return steps


def all_jobs(client):
    jobs, token = [], ""
    while True:
        answer = client.ask("ListJobs", page_size=1000, page_token=token)
        jobs += answer.jobs
        token = answer.next_page_token
        if not token:
            return jobs


def fetched_sha256(client, job_id, name):
    digest = hashlib.sha256()
    for chunk in client.fetch(job_id, name):
        digest.update(chunk.data)
    return digest.hexdigest()


def content_of_results(client, job):
    """Digest of every name, number and text in results.h5, without the digest of the case: the title of an
    undisturbed twin has no pauses. Empty where there are no results."""
    if RESULTS not in {artifact.name for artifact in job.artifacts}:
        return ""
    data = b"".join(chunk.data for chunk in client.fetch(job.id, RESULTS))
    if not data.startswith(b"\x89HDF"):  # of the casting that only pretends
        return hashlib.sha256(data).hexdigest()
    digest = hashlib.sha256()

    def add(name, item):
        digest.update(name.encode())
        for key in sorted(set(item.attrs) - {"case_sha256"}):
            digest.update(f"{key} {item.attrs[key]!r}".encode())
        if isinstance(item, h5py.Dataset):
            value = item[()]
            digest.update(f"{item.dtype} {item.shape}".encode())
            if item.dtype.hasobject:  # texts
                digest.update(repr(list(value) if item.shape else value).encode())
            else:
                digest.update(value.tobytes())

    with h5py.File(io.BytesIO(data), "r") as results:
        add("/", results)
        results.visititems(add)
    return digest.hexdigest()


@functools.cache
def undisturbed_bytes(worker, serialised):
    case = case_pb2.Case.FromString(serialised)
    with Scene(random.Random(0), worker) as scene:
        begin = time.monotonic()
        job_id = scene.submit(case)
        scene.wait_until_ended()
        seconds = time.monotonic() - begin
        job = scene.client.job(job_id)
        return Undisturbed(job.state, failure_of(job),
                           [physics(step) for step in all_steps(scene.client, job_id)],
                           {a.name: a.sha256 for a in job.artifacts},
                           content_of_results(scene.client, job), seconds)


def undisturbed(worker, case):
    """Of this case on this worker; computed once."""
    return undisturbed_bytes(worker, without_pauses(case).SerializeToString(deterministic=True))


def failure_of(job):
    return job.failure.SerializeToString(deterministic=True) if job.HasField("failure") else b""


def judge(scene, seconds=60, torn=()):
    """Waits for the end of every acknowledged job, then compares each with its undisturbed twin.

    torn: ids of jobs whose event log was damaged; they may miss the record that was hit, if they say so.
    """
    count = Count()
    try:
        scene.send_again()
    except grpc.RpcError as error:
        count.found("wrong", f"a submission again: {error.details()}")
    listed = count_listed(scene, count)
    end = time.monotonic() + seconds
    for job_id, expected in scene.acknowledged.items():
        if listed.get(job_id, 0) == 0:
            count.found("lost", f"job {job_id} is gone")
            continue
        try:
            judge_job(scene, job_id, expected, end, count, job_id in torn)
        except grpc.RpcError as error:
            count.found("wrong", f"job {job_id}: {error.code().name}: {error.details()}")
    return count


def count_listed(scene, count):
    """How often each id is listed; finds what nobody asked for, and requests served twice."""
    listed = {}
    requests = {}
    for job in all_jobs(scene.client):
        if job.id in scene.foreign_jobs:
            continue
        listed[job.id] = listed.get(job.id, 0) + 1
        requests.setdefault(job.request_id, set()).add(job.id)
        if job.id not in scene.acknowledged:
            count.found("duplicated", f"job {job.id} was never acknowledged")
    for job_id, times in listed.items():
        if times > 1:
            count.found("duplicated", f"job {job_id} is listed {times} times")
    for request, ids in requests.items():
        if len(ids) > 1:
            count.found("duplicated", f"{request} has {len(ids)} jobs")
    return listed


def judge_job(scene, job_id, expected, end, count, torn):
    job = wait_for_end(scene.client, job_id, expected, end)
    twin = undisturbed(scene.worker, expected.case)
    state = twin.state if expected.state is None else expected.state
    name = job_pb2.JobState.Name
    if job.state != state:
        words = job.failure.message or job.held
        return count.found("wrong", f"job {job_id} is {name(job.state)}, not {name(state)}: {words}")
    if job.request_id != expected.request_id:
        count.found("wrong", f"job {job_id} forgot its request_id")
    whole = expected.state is None
    if whole and failure_of(job) != twin.failure:
        count.found("wrong", f"job {job_id} failed for another reason: {job.failure.message}")
    judge_events(scene.client, job, count, torn)
    judge_history(scene.client, job_id, twin, whole, count, torn)
    if whole:
        judge_files(scene.client, job, twin, count)


def wait_for_end(client, job_id, expected, end):
    states = TERMINAL if expected.state in (None, *TERMINAL) else (expected.state,)
    with contextlib.suppress(AssertionError):  # judged by its state
        until(lambda: client.job(job_id).state in states, end - time.monotonic())
    return client.job(job_id)


def judge_events(client, job, count, torn):
    """Sequence numbers without a hole, steps without a hole, one end."""
    if job.state not in TERMINAL:
        return
    events = list(client.watch(job.id))
    numbers = [event.sequence for event in events]
    if len(set(numbers)) < len(numbers):
        count.found("duplicated", f"job {job.id}: an event is there twice")
    elif numbers != list(range(1, len(numbers) + 1)) and not torn:
        count.found("lost", f"job {job.id}: its events have a hole")
    ends = [event.sequence for event in events if event.state_change.terminal]
    if len(ends) != 1 or ends[0] != numbers[-1]:
        count.found("wrong", f"job {job.id}: its events end {len(ends)} times")
    fault = fault_of_steps(events)
    if fault and not (torn and says_damage(events)):
        count.found(fault[0], f"job {job.id}: {fault[1]}")


def fault_of_steps(events):
    """Follows the steps through every resumption. Returns what is wrong first, or None."""
    last, just_started = 0, False
    for event in events:
        if event.HasField("resumed"):
            if event.resumed.step > last:
                return "lost", f"resumed after step {event.resumed.step}, but told only {last}"
            last = event.resumed.step
        elif event.HasField("state_change"):
            just_started = event.state_change.state == job_pb2.RUNNING
        elif event.HasField("step"):
            step = event.step.step
            if step == 1 and just_started:  # started over
                last = 0
            just_started = False
            if step > last + 1:
                return "lost", f"steps {last + 1} to {step - 1} are missing"
            if step <= last:
                return "duplicated", f"step {step} comes again"
            last = step
    return None


def says_damage(events):
    return any(event.message.level == job_pb2.JobEvent.Message.WARNING for event in events)


def judge_history(client, job_id, twin, whole, count, torn):
    """A job that did not run to its end has the beginning of its twin's history."""
    steps = [physics(step) for step in all_steps(client, job_id)]
    if steps == (twin.steps if whole else twin.steps[:len(steps)]):
        return
    if torn and len(steps) == len(twin.steps) - 1 and set(steps) <= set(twin.steps):
        return
    if len(steps) < len(twin.steps):
        count.found("lost", f"job {job_id} has {len(steps)} steps of {len(twin.steps)}")
    else:
        count.found("wrong", f"job {job_id} has another history than an undisturbed run")


def judge_files(client, job, twin, count):
    """The bytes on the disk, those the job promises, and those of the twin are the same."""
    promised = {a.name: a.sha256 for a in job.artifacts}
    differing = {name for name in promised.keys() | twin.files.keys()
                 if promised.get(name) != twin.files.get(name)}
    if differing - {RESULTS} or differing and content_of_results(client, job) != twin.content:
        return count.found("wrong", f"job {job.id} has other results than an undisturbed run")
    if job.state != job_pb2.SUCCEEDED:
        return
    for name, sha256 in promised.items():
        if fetched_sha256(client, job.id, name) != sha256:
            count.found("wrong", f"job {job.id}: {name} is not what it promises")


def must(count, condition, note, seconds=0.0):
    """Counts it as wrong when something does not come about in time."""
    try:
        until(condition, seconds)
    except (AssertionError, grpc.RpcError):
        count.found("wrong", note)
