"""The face of a server: cases in, jobs, answers and studies out."""
from __future__ import annotations

import uuid
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import grpc

from dccast import errors
from dccast.cases import Case, Changes, Source, Value, changes_of, read_case, written
from dccast.jobs import Job
from dccast.judgements import Comparison
from dccast.runs import Answer
from dccast.studies import Study
from dccast.transport import Transport, endpoint
from dccast.v1 import case_pb2, job_pb2, judgement_pb2, service_pb2, study_pb2


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
            request_id=request_id or str(uuid.uuid4()), priority=job_pb2.Priority.Value(priority.upper()), labels=labels, changes=read.changes)))

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
            if error.code != "ABORTED":
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
            raise errors.DccastError(job_pb2.Failure.Kind.Name(answer.failure.kind),
                                     answer.failure.message, field=answer.failure.finding)
        return answer

    def job(self, job: str) -> Job:
        """A job by its id, the unique beginning of one, or "last": the newest one of this user, besides
        runs of studies."""
        if job == "last":
            user = self._transport.call("WhoAmI", service_pb2.WhoAmIRequest()).name
            found = [one.message for one in self.jobs(owner=user, limit=1000) if not one.message.study]
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
        jobs: list[Job] = []
        while len(jobs) < limit:
            request.page_size = min(1000, limit - len(jobs))
            page = self._transport.call("ListJobs", request)
            jobs += [Job(self._transport, message) for message in page.jobs]
            request.page_token = page.next_page_token
            if not page.next_page_token:
                break
        return jobs

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
        read = self.read(case, changes, **keys)
        plan = study_pb2.SweepPlan(
            axes=[study_pb2.SweepPlan.Axis(key=key, values=[written(value) for value in values])
                  for key, values in axes.items()],
            design=study_pb2.SweepPlan.Design.Value(design.upper()), runs=runs, seed=seed)
        return Study(self._transport, self._call_about(read, "CreateStudy", study_pb2.CreateStudyRequest(
            request_id=request_id or str(uuid.uuid4()), sweep=plan, priority=job_pb2.Priority.Value(priority.upper()), labels=labels,
            changes=read.changes)))

    def remedy(self, job: Job) -> Study:
        """What helps against the findings of an ended job: drafts with one lever of the plant moved.
        `judgement()` of the study says which lever, and how far. A job has one such study."""
        return Study(self._transport, self._transport.call("CreateStudy", study_pb2.CreateStudyRequest(
            request_id=f"remedy/{job.id}", remedy=study_pb2.RemedyPlan(job=job.id))))

    def study(self, study: str) -> Study:
        """A study by its id."""
        return Study(self._transport, self._transport.call("GetStudy", study_pb2.GetStudyRequest(id=study)))

    def studies(self, limit: int = 50) -> list[Study]:
        """Studies, newest first; at most 1000."""
        page = self._transport.call("ListStudies", study_pb2.ListStudiesRequest(page_size=limit))
        return [Study(self._transport, message) for message in page.studies]

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


def _compared(run: Job | Answer, name: str) -> judgement_pb2.ComparedRun:
    if isinstance(run, Job):
        return judgement_pb2.ComparedRun(job=run.id, name=name)
    if run.job:
        return judgement_pb2.ComparedRun(job=run.job, name=name)
    return judgement_pb2.ComparedRun(answer=run.key, name=name)
