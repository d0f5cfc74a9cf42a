"""The face of a server: cases in, jobs, answers and studies out."""
from __future__ import annotations

import uuid
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar, Union

import grpc

from dccast import errors
from dccast.cases import Case, Changes, Source, Value, changes_of, read_case, written
from dccast.jobs import Job
from dccast.judgements import Comparison, Judgement
from dccast.runs import Answer
from dccast.studies import Study
from dccast.transport import Transport, endpoint
from dccast.v1 import case_pb2, job_pb2, judgement_pb2, recipe_pb2, service_pb2, study_pb2

Entry = TypeVar("Entry", Job, Study)

#: Keys of a case: names, or the two ends of each by name.
Ranges = Union[Mapping[str, Sequence[Value]], Sequence[str]]


def connect(server: str | None = None) -> Service:
    """A server by its address, or the name of a login; without one by $DCCAST_SERVER, else the settings
    file of the command line client, else its first login, else this machine. The first call connects.

    >>> dccast.connect().info().workers > 0
    True
    """
    return Service(Transport(endpoint(server)))


class Service:
    """Calls of one server.

    A case is the path of a file, the text of one, the name of a shipped one, or what `read` returned.
    Changes are given by path, {"schedule.casting_speed": "55 mm/min"}, or as keywords with two
    underscores for each dot, schedule__casting_speed="55 mm/min"; what `dccast submit --set` takes.
    """

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    @property
    def server(self) -> str:
        return self._transport.server

    def info(self) -> service_pb2.GetServerInfoResponse:
        """What the server is and how busy it is."""
        answer: service_pb2.GetServerInfoResponse = self._transport.call(
            "GetServerInfo", service_pb2.GetServerInfoRequest())
        return answer

    def read(self, case: Source, changes: Changes | None = None, **keys: Value) -> Case:
        """The case with the changes, for calls that follow. @raises DccastError  its faults"""
        return read_case(self._transport, case, changes_of(changes, keys))

    def new_slab(self, size: str, alloy: str = "", speed: str = "", water: str = "") -> Case:
        """The start of a slab as `dccast new --slab` writes it: the shipped case that is nearest, with these
        figures.

        >>> dccast.connect().new_slab("1320x570mm", speed="45..55mm/min").message.section.half_width_m
        0.66
        """
        slab = service_pb2.SlabStart(size=size, alloy=alloy, speed=speed, water=water)
        return Case(self._transport.call("ReadCase", service_pb2.ReadCaseRequest(slab=slab)).case)

    def validate(self, case: Source, changes: Changes | None = None,
                 **keys: Value) -> service_pb2.ValidateCaseResponse:
        """Estimate, findings, warnings and the complete case. @raises DccastError  its faults

        >>> dccast.connect().validate("start-3d", quality="draft").estimate.steps > 0
        True
        """
        read = self.read(case, changes, **keys)
        verdict: service_pb2.ValidateCaseResponse = self._call_about(
            read, "ValidateCase", service_pb2.ValidateCaseRequest())
        if verdict.faults:
            raise errors.invalid_case(verdict.faults)
        return verdict

    def submit(self, case: Source, changes: Changes | None = None, *, priority: str = "normal",
               labels: Sequence[str] = (), request_id: str = "", **keys: Value) -> Job:
        """Queues a case. When this returns the job survives a crash of the server.

        @param request_id  the same id and case give the same job; without one every call makes a job
        @raises DccastError  the faults of the case, a full queue

        >>> dccast.connect().submit("start-2d-thickness", {"time.end": "20 s"}, quality="draft").wait()
        <dccast.Job ... SUCCEEDED 'Start stage, thickness section, 0 to 145 s': corner ... mm, ... at 20 s>
        """
        read = self.read(case, changes, **keys)
        return Job(self._transport, self._call_about(read, "SubmitJob", service_pb2.SubmitJobRequest(
            request_id=request_id or str(uuid.uuid4()),
            priority=job_pb2.Priority.Value(priority.upper()), labels=labels, changes=read.changes)))

    def _put(self, case: Case, request: Any) -> None:
        """Gives a request the case, and the server the files that it does not have yet."""
        for file in case.files:
            self._transport.upload(file.message, file.path)
        request.case.CopyFrom(case.message)
        del request.attachments[:]
        request.attachments.extend(file.message for file in case.files)

    def _call_about(self, case: Case, method: str, request: Any) -> Any:
        """A call about a case; once more where the server has lost a file of it, as by a restart."""
        self._put(case, request)
        try:
            return self._transport.call(method, request)
        except errors.DccastError as error:
            if error.reason != "ATTACHMENT_MISSING":
                raise
        self._put(case, request)
        return self._transport.call(method, request)

    def query(self, case: Source, changes: Changes | None = None, *, keep: bool = False,
              on_step: Callable[[job_pb2.StepReport], None] = lambda _: None,
              on_wait: Callable[[str, float], None] = lambda reason, seconds: None,
              **keys: Value) -> Answer:
        """Runs a case at once, beside the queue. Ctrl-C ends the run.

        @param on_wait  called with what the run waits for, and for how long [s]
        @param keep  the run stays on the server as a job
        @raises DccastError  the faults of the case; a run that failed, with its cause as `code`
        """
        read = self.read(case, changes, **keys)
        answer = Answer()
        request = service_pb2.QueryButtCurlRequest(changes=read.changes, keep=keep)
        self._put(read, request)
        stream = self._transport.stream("QueryButtCurl", request)
        try:
            for response in stream:
                answer.take(response)
                if response.HasField("step"):
                    on_step(response.step)
                elif response.HasField("waiting"):
                    on_wait(response.waiting.reason, response.waiting.expected_s)
        except grpc.RpcError as error:
            raise errors.of_call(error, self.server) from None
        finally:
            stream.cancel()
        if answer.failure is not None:
            raise errors.DccastError(job_pb2.Finding.Kind.Name(answer.failure.kind),
                                     answer.failure.message, field=answer.failure.code)
        return answer

    def job(self, job: str) -> Job:
        """A job by its id, the unique beginning of one, or "last": the newest one of this user, besides
        runs of studies."""
        if job == "last":
            user = self._transport.call("WhoAmI", service_pb2.WhoAmIRequest()).name
            found = [listed.message for listed in self.jobs(owner=user, limit=1000)
                     if not listed.message.study]
        elif len(job) < 36:
            request = service_pb2.ListJobsRequest(page_size=2, id_prefix=job)
            found = list(self._transport.call("ListJobs", request).jobs)
        else:
            return Job(self._transport, self._transport.call("GetJob", service_pb2.GetJobRequest(id=job)))
        if not found:
            raise errors.DccastError("NOT_FOUND", f"no job {job!r} on {self.server}")
        if job != "last" and len(found) > 1:
            raise errors.DccastError("INVALID_ARGUMENT", f"{job!r} begins more than one job")
        return Job(self._transport, found[0])

    def jobs(self, *, states: Sequence[str] = (), labels: Sequence[str] = (), owner: str = "",
             study: str = "", limit: int = 50) -> list[Job]:
        """Jobs, newest first, e.g. jobs(states=["RUNNING"])."""
        request = service_pb2.ListJobsRequest(
            states=[job_pb2.JobState.Value(state.upper()) for state in states], labels=labels,
            owner=owner, study=study)
        return self._listed("ListJobs", request, limit, "jobs", Job)

    def _listed(self, method: str, request: Any, limit: int, field: str,
                entry: Callable[[Transport, Any], Entry]) -> list[Entry]:
        """Reads the pages of a list until there are `limit` entries or no more.

        @param field  of a page: its entries
        """
        found: list[Entry] = []
        while len(found) < limit:
            request.page_size = min(1000, limit - len(found))
            page = self._transport.call(method, request)
            found += [entry(self._transport, message) for message in getattr(page, field)]
            request.page_token = page.next_page_token
            if not page.next_page_token:
                break
        return found

    def sweep(self, case: Source, axes: Mapping[str, Sequence[Value]], *, design: str = "grid",
              runs: int = 0, seed: int = 0, changes: Changes | None = None, priority: str = "normal",
              labels: Sequence[str] = (), request_id: str = "", **keys: Value) -> Study:
        """Queues a case at many values of some keys.

        @param axes    values by key; of a Latin hypercube the two ends of each range
        @param design  "grid", "list" or "latin_hypercube" of so many `runs`

        >>> study = dccast.connect().sweep("start-2d-thickness", {
        ...     "schedule.casting_speed": [f"{v} mm/min" for v in (45, 50, 55, 60, 65)]},
        ...     quality="draft", time__end="20 s").wait()
        >>> study.table["schedule.casting_speed"].round(5).tolist()
        [0.00075, 0.00083, 0.00092, 0.001, 0.00108]
        >>> study.predict(schedule__casting_speed="57 mm/min").runs
        5
        """
        plan = study_pb2.SweepPlan(
            axes=_axes(axes), design=study_pb2.SweepPlan.Design.Value(design.upper()), runs=runs, seed=seed)
        return self._begin(self.read(case, changes, **keys), study_pb2.CreateStudyRequest(
            request_id=request_id, sweep=plan, priority=job_pb2.Priority.Value(priority.upper()),
            labels=labels))

    def uncertainty(self, case: Source, *, only: Ranges = (), runs: int = 64, seed: int = 0,
                    changes: Changes | None = None, labels: Sequence[str] = (), **keys: Value) -> Study:
        """Queues drafts of a case over what its data may be; `judgement()` of the study says how sure
        the curl is, and what to measure first.

        @param only  these data alone: names, with the range that the case has for each, or the two
                     ends by name; absent: all data with a range

        >>> study = dccast.connect().uncertainty(
        ...     "start-2d-thickness", runs=8, time__end="20 s",
        ...     only={"cooling.bottom_block.temperature": ["60 degC", "100 degC"]}).wait()
        >>> study.evaluate().study.sweep.axes[0].key
        'cooling.bottom_block.temperature'
        """
        plan = study_pb2.SweepPlan(axes=_axes(only), design=study_pb2.SweepPlan.LATIN_HYPERCUBE,
                                   purpose=study_pb2.SweepPlan.UNCERTAINTY, runs=runs, seed=seed)
        return self._begin(self.read(case, changes, **keys),
                           study_pb2.CreateStudyRequest(sweep=plan, labels=labels))

    def sensitivity(self, case: Source, *, only: Ranges = (), changes: Changes | None = None,
                    labels: Sequence[str] = (), **keys: Value) -> Study:
        """Queues two drafts for every lever and datum of a case; `judgement()` of the study says what
        matters.

        @param only  these data alone, as in `uncertainty`
        """
        plan = study_pb2.SweepPlan(axes=_axes(only), design=study_pb2.SweepPlan.ENDS,
                                   purpose=study_pb2.SweepPlan.SENSITIVITY)
        return self._begin(self.read(case, changes, **keys),
                           study_pb2.CreateStudyRequest(sweep=plan, labels=labels))

    def calibrate(self, case: Source, measured: Mapping[str, Mapping[str, Sequence[float]]], *,
                  free: Ranges = (), runs: int = 64, seed: int = 0, noise: Mapping[str, float] | None = None,
                  changes: Changes | None = None, labels: Sequence[str] = (), **keys: Value) -> Study:
        """Queues drafts over data that are inferred from measurements; `judgement()` of the study says
        what these suggest, once it has ended. The command `dccast calibrate` also checks it with
        further runs.

        @param measured  by monitor: columns "time_s" or "cast_length_m", and "curl_m" or
                         "temperature_c"
        @param free   data to infer, as `only` of `uncertainty`; absent: those to which case or card
                      gives a range
        @param noise  standard deviation of a reading by monitor [m] or [K]; absent: inferred
        """
        curves = []
        for monitor, columns in measured.items():
            curve = study_pb2.MeasuredCurve(monitor=monitor, noise=(noise or {}).get(monitor, 0.0))
            for name, readings in columns.items():
                getattr(curve, name).extend(readings)
            curves.append(curve)
        plan = study_pb2.SweepPlan(
            axes=_axes(free), design=study_pb2.SweepPlan.LATIN_HYPERCUBE,
            purpose=study_pb2.SweepPlan.CALIBRATION, runs=runs, seed=seed, measured=curves)
        return self._begin(self.read(case, changes, **keys),
                           study_pb2.CreateStudyRequest(sweep=plan, labels=labels))

    def design_recipe(self, case: Source, band_m: tuple[float, float],
                      numbers: Mapping[str, tuple[float, float]], *, monitor: str = "", drafts: int = 128,
                      castings: int = 12, candidates: int = 4, seed: int = 0,
                      speed_rate_m_per_s2: float = 1.7e-5,
                      flow_rate_m2_per_s2: float = 5.6e-5, changes: Changes | None = None,
                      labels: Sequence[str] = (), **keys: Value) -> Study:
        """Queues the search for a recipe that keeps the curl inside a band whatever the data of the case
        are; `judgement()` of the study has the recipes, `evaluate().recipe` their changes of the case.

        @param band_m   least and greatest curl
        @param numbers  ends between which each number of the recipe may be, in SI: speed_start,
                        speed_run, speed_ramp, filling, hold, water_start, water_run, water_ramp
                        (docs/recipe.md); one that is absent stays as in the case
        """
        plan = recipe_pb2.RecipePlan(
            numbers=[recipe_pb2.RecipePlan.Number(name=name, low=low, high=high)
                     for name, (low, high) in numbers.items()],
            monitor=monitor, least_curl_m=band_m[0], greatest_curl_m=band_m[1],
            greatest_speed_rate_m_per_s2=speed_rate_m_per_s2,
            greatest_flow_rate_m2_per_s2=flow_rate_m2_per_s2, drafts=drafts, castings=castings,
            candidates=candidates, seed=seed)
        return self._begin(self.read(case, changes, **keys),
                           study_pb2.CreateStudyRequest(recipe=plan, labels=labels))

    def remedy(self, job: Job) -> Study:
        """What helps against the findings of an ended job: drafts with one lever of the plant moved.
        `judgement()` of the study says which lever, and how far. A job has one such study."""
        return Study(self._transport, self._transport.call("CreateStudy", study_pb2.CreateStudyRequest(
            request_id=f"remedy/{job.id}", remedy=study_pb2.RemedyPlan(job=job.id))))

    def _begin(self, read: Case, request: study_pb2.CreateStudyRequest) -> Study:
        """Queues a study of a case."""
        request.request_id = request.request_id or str(uuid.uuid4())
        request.changes.extend(read.changes)
        return Study(self._transport, self._call_about(read, "CreateStudy", request))

    def study(self, study: str) -> Study:
        """A study by its id."""
        return Study(self._transport, self._transport.call("GetStudy", study_pb2.GetStudyRequest(id=study)))

    def studies(self, limit: int = 50, *, labels: Sequence[str] = (), owner: str = "") -> list[Study]:
        """Studies, newest first, e.g. studies(labels=["trial-7"])."""
        request = study_pb2.ListStudiesRequest(labels=labels, owner=owner)
        return self._listed("ListStudies", request, limit, "studies", Study)

    def judge(self, run: Job | Answer | Source, with_frame: bool = False) -> Judgement:
        """What the server concludes from one run: the largest curl with its error, when it came and where
        the heat left meanwhile; tables "curls", "end", "recipe", "checks" and "basis"; charts of its
        histories. A case is run, as by `query`.

        @param with_frame  also what the last stored frame of a job shows: gap, contact and pull-in

        >>> service = dccast.connect()
        >>> answer = service.query("start-2d-thickness", quality="draft", time__end="20 s")
        >>> service.judge(answer).charts[0].heading
        'curl against time'
        """
        found = run if isinstance(run, (Job, Answer)) else self.query(run)
        request = judgement_pb2.CompareRunsRequest(runs=[_compared(found, "")], with_frame=with_frame)
        return Judgement(self._transport.call("CompareRuns", request).judgement)

    def compare(self, *runs: Job | Answer | Source, paired: bool = False) -> Comparison:
        """Compares runs with the first one: what differs, whether it is real, that is, larger than its
        error, and what differed before it. Jobs and answers are compared as they are; cases are run, as
        by `query`.

        @param paired  also run every case at another quality, for the error of the difference
        """
        request = judgement_pb2.CompareRunsRequest()
        for run in runs:
            if isinstance(run, (Job, Answer)):
                request.runs.append(_compared(run, ""))
                continue
            answer = self.query(run)
            request.runs.append(_compared(answer, answer.case.title))
            if paired:
                draft = answer.case.quality == case_pb2.DRAFT
                companion = self.query(run, quality="engineering" if draft else "draft")
                request.companions.append(_compared(companion, ""))
        return Comparison(self._transport.call("CompareRuns", request))


def _axes(ranges: Ranges) -> list[study_pb2.SweepPlan.Axis]:
    """Axes of a plan; the server knows the ends of those that are only named."""
    if not isinstance(ranges, Mapping):
        return [study_pb2.SweepPlan.Axis(key=key) for key in ranges]
    return [study_pb2.SweepPlan.Axis(key=key, values=[written(value) for value in values])
            for key, values in ranges.items()]


def _compared(run: Job | Answer, name: str) -> judgement_pb2.ComparedRun:
    if isinstance(run, Job):
        return judgement_pb2.ComparedRun(job=run.id, name=name)
    if run.job:
        return judgement_pb2.ComparedRun(job=run.job, name=name)
    return judgement_pb2.ComparedRun(answer=run.key, name=name)
