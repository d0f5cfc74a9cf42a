"""The face of a server: cases in, jobs, answers and studies out."""
from __future__ import annotations

import datetime
import itertools
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Union

import grpc

from dccast import errors
from dccast.cases import Case, Changes, Source, Value, changes_of, read_case, written
from dccast.castings import Preparation
from dccast.jobs import Job
from dccast.judgements import Comparison, Judgement
from dccast.runs import Answer
from dccast.studies import Study
from dccast.transport import DEADLINE_S, Transport, endpoint
from dccast.v1 import (case_pb2, follow_pb2, job_pb2, judgement_pb2, line_pb2, recipe_pb2, service_pb2,
                       study_pb2)

#: Keys of a case: names, or the two ends of each by name.
Ranges = Union[Mapping[str, Sequence[Value]], Sequence[str]]


def connect(server: str | None = None, timeout_s: float = DEADLINE_S) -> Service:
    """A server by its address, or the name of a login; without one by $DCCAST_SERVER, else the settings
    file of the command line client, else its first login, else this machine. The first call connects.

    @param timeout_s  of each call but streams; then it raises DccastError of code DEADLINE_EXCEEDED

    >>> dccast.connect().info().workers > 0
    True
    """
    return Service(Transport(endpoint(server), timeout_s))


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
        """Its address."""
        return self._transport.server

    def info(self) -> service_pb2.GetServerInfoResponse:
        """What the server is and how busy it is."""
        answer: service_pb2.GetServerInfoResponse = self._transport.call(
            "GetServerInfo", service_pb2.GetServerInfoRequest())
        return answer

    def web_line(self) -> str:
        """A link that signs in a browser as the user of this login, once, within ten minutes.

        @raises DccastError  FAILED_PRECONDITION: a local user who is not in the list of users
        """
        line = self._transport.call("IssueSignIn", service_pb2.IssueSignInRequest(), repeat=False)
        return str(line.link)

    def tokens(self) -> list[service_pb2.Token]:
        """Logins and sessions of browsers of the user of this login, oldest first."""
        return list(self._transport.call("ListTokens", service_pb2.ListTokensRequest()).tokens)

    def revoke_token(self, token: str = "") -> None:
        """Ends a login or session by its id; without one this login."""
        self._transport.call("RevokeToken", service_pb2.RevokeTokenRequest(id=token), repeat=False)

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
        read = self._transport.call("ReadCase", service_pb2.ReadCaseRequest(slab=slab))
        return Case(read.case, text=read.text)

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
               labels: Sequence[str] = (), request_id: str = "", study: str = "",
               after: Sequence[Job | str] = (), after_end: str = "success",
               begin: datetime.datetime | None = None, time_limit_s: float = 0.0, mail: str = "",
               **keys: Value) -> Job:
        """Queues a case. When this returns the job survives a crash of the server.

        @param request_id  the same id and case give the same job; without one every call makes a job
        @param study  a UUID of your choice for jobs that belong together
        @param after  jobs that must end first; once one cannot end as it must, this one is cancelled
        @param after_end  how they must end: "success", "failure" or "any_end"
        @param begin  not started earlier; without a zone it is the time of this machine
        @param time_limit_s  wall time after which it fails; 0: the limit of the server
        @param mail  address that is told when it has ended
        @raises DccastError  the faults of the case, a full queue

        >>> dccast.connect().submit("start-2d-thickness", {"time.end": "20 s"}, quality="draft").wait()
        <dccast.Job ... SUCCEEDED 'Start stage, thickness section, 0 to 145 s': corner ... mm, ... at 20 s>
        """
        request = service_pb2.SubmitJobRequest(
            request_id=request_id, priority=errors.number_of(job_pb2.Priority, priority), labels=labels,
            study=study, after=[job if isinstance(job, str) else job.id for job in after],
            after_end=errors.number_of(job_pb2.AwaitedEnd, f"awaited_{after_end}"),
            time_limit_s=time_limit_s, mail=mail)
        if begin is not None:
            request.begin_time.FromDatetime(begin.astimezone(datetime.timezone.utc))
        return self._submit(self.read(case, changes, **keys), request)

    def prepare(self, case: Source, changes: Changes | None = None, *, labels: Sequence[str] = (),
                **keys: Value) -> Preparation:
        """Has the server compute what the forecast of a casting rests on (docs/following.md). The same
        casting, whatever its title and quality, finds what is there; `wait` waits for all of it.

        @param labels  of the studies that are begun
        """
        read = self.read(case, changes, **keys)
        request = study_pb2.PrepareCastingRequest(changes=read.changes, labels=labels,
                                                  case_file=read.text.encode())

        def ask() -> study_pb2.Preparation:
            answer: study_pb2.Preparation = self._call_about(read, "PrepareCasting", request)
            return answer
        return Preparation(self._transport, ask)

    def follow(self, case: Source, changes: Changes | None = None, *,
               noise_m: Mapping[str, float] | None = None, zero_m: Mapping[str, float] | None = None,
               line: str = "", ensemble: Study | None = None,
               labels: Sequence[str] = (), **keys: Value) -> Job:
        """A job that computes a casting while it is cast, as far as readings have been given to its
        `append`. With gauges its `forecast` has the curls to come, best after `prepare`.

        @param noise_m   standard deviation of a measured curl, by monitor with a gauge
        @param zero_m    that of the unknown zero of a gauge, by monitor; absent: known
        @param line      on which the casting is made
        @param ensemble  study of uncertainty of this plan instead of what `prepare` computed

        >>> job = dccast.connect().follow("start-2d-thickness", quality="draft", time__end="20 s")
        >>> job.append({"time_s": [-60.0, 20.0], "casting_speed_m_per_s": [0.0, 9e-4]}, close=True).number
        3
        >>> job.wait().state
        'SUCCEEDED'
        """
        read = self.read(case, changes, **keys)
        following = follow_pb2.Following(line=line, gauges=[
            follow_pb2.Gauge(monitor=monitor, noise_m=noise, zero_m=(zero_m or {}).get(monitor, 0.0))
            for monitor, noise in (noise_m or {}).items()])
        if following.gauges or ensemble is not None:
            there = self._call_about(read, "PrepareCasting", study_pb2.PrepareCastingRequest(
                changes=read.changes, case_file=read.text.encode(), begins_now=True))
            following.plan_job = there.plan_job
            following.ensemble = there.ensemble.id if ensemble is None else ensemble.id
            if ensemble is None:
                following.pairs, following.levers = there.pairs.id, there.levers.id
        return self._submit(read, service_pb2.SubmitJobRequest(following=following, labels=labels))

    def _submit(self, read: Case, request: service_pb2.SubmitJobRequest) -> Job:
        """Queues a job of a case."""
        request.request_id = request.request_id or str(uuid.uuid4())
        request.changes.extend(read.changes)
        request.case_file = read.text.encode()
        return Job(self._transport, self._call_about(read, "SubmitJob", request))

    def lines(self) -> list[line_pb2.Line]:
        """The lines, without their castings."""
        return list(self._transport.call("ListLines", line_pb2.ListLinesRequest()).lines)

    def line(self, name: str) -> line_pb2.Line:
        """A line by its name."""
        return self._line("GetLine", line_pb2.GetLineRequest(id=name))

    def add_castings(self, name: str, castings: Sequence[Mapping[str, Any]],
                     request_id: str = "") -> list[str]:
        """Adds castings that were not followed to a line: all or none, and the same request once.

        @param castings  each with a `recipe`, a Job or a case as `submit` takes it, and fields of
                         line.proto's LineCasting: `outcome` ("sound", "bled_out", "cracked", "hung_up",
                         "aborted"), `count`, `at_m`, `cold_curl_m`, `sawn_off_m`
        @return  ids of the records
        @raises DccastError  with all faults, of fields such as "castings[3].at"
        """
        request = line_pb2.AddCastingsRequest(id=name, request_id=request_id or str(uuid.uuid4()))
        recipes: list[Any] = []
        for casting in castings:
            typed = dict(casting)
            recipe = typed.pop("recipe")
            if not any(recipe is known for known in recipes):
                recipes.append(recipe)
                request.recipes.append(
                    line_pb2.CastingRecipe(job=recipe.id) if isinstance(recipe, Job)
                    else line_pb2.CastingRecipe(case=self.read(recipe).message))
            number = next(i for i, known in enumerate(recipes) if known is recipe)
            request.castings.add(recipe=number, record=_typed_casting(typed))
        answer = self._transport.call("AddCastings", request)
        if answer.faults:
            raise errors.invalid_case(answer.faults)
        return list(answer.castings)

    def edit_casting(self, name: str, casting: str, **typed: Any) -> line_pb2.LineCasting:
        """Says anew how a casting of a line went. @param typed  as in `add_castings`, all of it"""
        record: line_pb2.LineCasting = self._transport.call("EditCasting", line_pb2.EditCastingRequest(
            id=name, casting=casting, record=_typed_casting(typed)))
        return record

    def forget_castings(self, name: str, castings: Sequence[str]) -> None:
        """Takes single castings off a line, by the ids of their records."""
        self._transport.call("ForgetCastings", line_pb2.ForgetCastingsRequest(
            id=name, castings=castings), repeat=False)

    def restart_line(self, name: str) -> line_pb2.Line:
        """Begins it afresh, for a new mould or new water: its castings so far count no more."""
        return self._line("RestartLine", line_pb2.RestartLineRequest(id=name))

    def delete_line(self, name: str) -> None:
        """Removes a line. Its jobs and studies stay."""
        self._transport.call("DeleteLine", line_pb2.DeleteLineRequest(id=name), repeat=False)

    def _line(self, method: str, request: Any) -> line_pb2.Line:
        line: line_pb2.Line = self._transport.call(method, request)
        return line

    def alloys(self) -> list[case_pb2.Alloy]:
        """The alloy cards that a case may name."""
        return list(self._transport.call("ListAlloys", service_pb2.ListAlloysRequest()).alloys)

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
            raise errors.DccastError(errors.name_of(job_pb2.Finding.Kind, answer.failure.kind),
                                     answer.failure.message, field=answer.failure.code)
        return answer

    def job(self, job: str) -> Job:
        """A job by its id, the unique beginning of one, or "last": the newest one of this user, besides
        runs of studies."""
        if job == "last":
            user = self._transport.call("WhoAmI", service_pb2.WhoAmIRequest()).name
            newest = self._each("ListJobs", service_pb2.ListJobsRequest(owner=user), "jobs")
            found = list(itertools.islice((each for each in newest if not each.study), 1))
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
             study: str = "", title: str = "", limit: int | None = None) -> list[Job]:
        """Jobs, newest first, e.g. jobs(states=["RUNNING"]).

        @param title  with * and ? as in a shell
        @param limit  so many at most; None: all
        @raises UnknownState
        """
        request = service_pb2.ListJobsRequest(
            states=[errors.number_of(job_pb2.JobState, state) for state in states], labels=labels,
            owner=owner, study=study, title=title, page_size=min(limit or 1000, 1000))
        return [Job(self._transport, message)
                for message in itertools.islice(self._each("ListJobs", request, "jobs"), limit)]

    def _each(self, method: str, request: Any, field: str) -> Iterator[Any]:
        """The entries of a list, page by page. @param field  of a page: its entries"""
        while True:
            page = self._transport.call(method, request)
            yield from getattr(page, field)
            request.page_token = page.next_page_token
            if not page.next_page_token:
                return

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
            axes=_axes(axes), design=errors.number_of(study_pb2.SweepPlan.Design, design), runs=runs, seed=seed)
        return self._begin(self.read(case, changes, **keys), study_pb2.CreateStudyRequest(
            request_id=request_id, sweep=plan, priority=errors.number_of(job_pb2.Priority, priority),
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
                      flow_rate_m2_per_s2: float = 5.6e-5, line: str = "",
                      changes: Changes | None = None, labels: Sequence[str] = (), **keys: Value) -> Study:
        """Queues the search for a recipe that keeps the curl inside a band whatever the data of the case
        are; `judgement()` of the study has the recipes, `evaluate().recipe` their changes of the case.

        @param band_m   least and greatest curl
        @param numbers  ends between which each number of the recipe may be, in SI: speed_start,
                        speed_run, speed_ramp, filling, hold, water_start, water_run, water_ramp
                        (docs/recipe.md); one that is absent stays as in the case
        @param line     data that the castings of this line leave possible
        """
        plan = recipe_pb2.RecipePlan(
            numbers=[recipe_pb2.RecipePlan.Number(name=name, low=low, high=high)
                     for name, (low, high) in numbers.items()],
            monitor=monitor, least_curl_m=band_m[0], greatest_curl_m=band_m[1],
            greatest_speed_rate_m_per_s2=speed_rate_m_per_s2,
            greatest_flow_rate_m2_per_s2=flow_rate_m2_per_s2, drafts=drafts, castings=castings,
            candidates=candidates, seed=seed, line=line)
        return self._begin(self.read(case, changes, **keys),
                           study_pb2.CreateStudyRequest(recipe=plan, labels=labels))

    def convergence(self, case: Source, levels: int = 3, *, changes: Changes | None = None,
                    labels: Sequence[str] = (), **keys: Value) -> Study:
        """Queues a case on finer and finer meshes with shorter and shorter steps;
        `evaluate(curves=True).limits` are what its curls tend to."""
        return self._begin(self.read(case, changes, **keys), study_pb2.CreateStudyRequest(
            refinement=study_pb2.RefinementPlan(levels=levels), labels=labels))

    def design_mould(self, case: Source, *, tolerance_m: float = 0.5e-3, wanted_half_thickness_m: float = 0.0,
                     runs: int = 0, changes: Changes | None = None, labels: Sequence[str] = (),
                     **keys: Value) -> Study:
        """Queues the search for the mould opening of three segments that gives a flat cold slab.

        @param wanted_half_thickness_m  of the cold slab; 0: the half-opening of the case at its narrow face
        @param runs  at most; 0 for 12
        """
        plan = study_pb2.MouldPlan(tolerance_m=tolerance_m, maximum_runs=runs,
                                   wanted_half_thickness_m=wanted_half_thickness_m)
        return self._begin(self.read(case, changes, **keys),
                           study_pb2.CreateStudyRequest(mould=plan, labels=labels))

    def remedy(self, job: Job, *, line: str = "") -> Study:
        """What helps against the findings of an ended job: drafts with one lever of the plant moved.
        `judgement()` of the study says which lever, and how far. Each user has one such study for a job.

        @param line  with the data of a casting that what was cast on this line leaves possible
        """
        return Study(self._transport, self._transport.call("CreateStudy", study_pb2.CreateStudyRequest(
            find=True, remedy=study_pb2.RemedyPlan(job=job.id, line=line))))

    def _begin(self, read: Case, request: study_pb2.CreateStudyRequest) -> Study:
        """Queues a study of a case."""
        request.request_id = request.request_id or str(uuid.uuid4())
        request.changes.extend(read.changes)
        return Study(self._transport, self._call_about(read, "CreateStudy", request))

    def study(self, study: str) -> Study:
        """A study by its id."""
        return Study(self._transport, self._transport.call("GetStudy", study_pb2.GetStudyRequest(id=study)))

    def studies(self, limit: int | None = None, *, labels: Sequence[str] = (), owner: str = "") -> list[Study]:
        """Studies, newest first, e.g. studies(labels=["trial-7"]). @param limit  so many at most; None: all"""
        request = study_pb2.ListStudiesRequest(labels=labels, owner=owner, page_size=min(limit or 1000, 1000))
        return [Study(self._transport, message)
                for message in itertools.islice(self._each("ListStudies", request, "studies"), limit)]

    def judge(self, run: Job | Answer | Source, with_frame: bool = False, *, line: str = "") -> Judgement:
        """What the server concludes from one run: the largest curl with its error, when it came and where
        the heat left meanwhile; tables "curls", "end", "recipe", "checks" and "basis"; charts of its
        histories. A case is run, as by `query`.

        @param with_frame  also what the last stored frame of a job shows: gap, contact and pull-in
        @param line        also what the castings of this line say of its recipe

        >>> service = dccast.connect()
        >>> answer = service.query("start-2d-thickness", quality="draft", time__end="20 s")
        >>> service.judge(answer).charts[0].heading
        'curl against time'
        """
        found = run if isinstance(run, (Job, Answer)) else self.query(run)
        request = judgement_pb2.CompareRunsRequest(runs=[_compared(found, "")], with_frame=with_frame,
                                                   line=line)
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


def _typed_casting(typed: Mapping[str, Any]) -> line_pb2.LineCasting:
    """What a person says of castings, as a record."""
    fields: dict[str, Any] = {"count": 1, **typed}
    if isinstance(outcome := fields.get("outcome"), str):
        fields["outcome"] = errors.number_of(line_pb2.LineCasting.Outcome, outcome.replace("-", "_"))
    return line_pb2.LineCasting(**fields)


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
