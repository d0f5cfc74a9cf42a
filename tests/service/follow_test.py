#!/usr/bin/python3
"""A job that follows a casting: its record, its levers, kills of client, daemon and worker."""
import datetime
import json
import os
import pathlib
import random
import signal
import subprocess
import time

import grpc
import numpy

from dccast.v1 import case_pb2, follow_pb2, job_pb2, study_pb2
from real_run_test import RealRunTest, physics
from support import main
from waiting import WAIT_FACTOR, stays, until

CASE = os.path.join(os.path.dirname(__file__), "..", "..", "cases", "start-2d-thickness.toml")
END = 40  # s of casting: a second of computing at draft


def levers(t):
    """A casting that is a fifth faster and wetter than its plan by turns."""
    share = 1.2 if (t // 15) % 2 else 0.9
    speed = 0.0 if t <= 0 else 40e-3 / 60 * share
    return speed, 1.5e-3 * share, 680.0


def readings(begin=-60, end=END, first=1):
    made = []
    for number, t in enumerate(range(begin, end + 1), first):
        speed, water, metal = levers(t)
        made.append(follow_pb2.Reading(number=number, time_s=t, casting_speed_m_per_s=speed,
                                       water_flow_m2_per_s=water, casting_temperature_c=metal))
    return made


def table(begin=-60, end=END):
    lines = ["time [s], speed [mm/min], water [l/min/m], metal [degC], operator [1]"]
    for t in range(begin, end + 1):
        speed, water, metal = levers(t)
        lines.append(f"{t}, {speed * 6e4!r}, {water * 6e4!r}, {metal}, 3")
    return "\n".join(lines) + "\n"


class FollowTest(RealRunTest):
    def dccast(self, *words, **rest):
        return subprocess.Popen(self.client_command(*words), stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True, **rest)

    def follow(self, end=END, **following):
        """A job that follows readings, without any so far."""
        with open(CASE, encoding="utf-8") as file:
            text = file.read().replace('\nend = "145 s"', f'\nend = "{end} s"')
        answer = self.client.ask("ReadCase", text=text)
        answer.case.quality = case_pb2.DRAFT
        return self.client.submit(answer.case, following=follow_pb2.Following(**following)).id

    def finished_draft(self, end):
        job_id = self.submit_case("quality=draft", f"time.end={end} s", path=CASE)
        self.client.until_state(job_id, job_pb2.SUCCEEDED, seconds=60)
        return job_id

    def append(self, job_id, *added):
        return self.client.ask("AppendReadings", id=job_id, readings=added)

    def steps_at_end(self, job_id):
        return self.finished_steps(job_id)[1]

    def case_file(self, end=END):
        path = self.in_folder("plan.toml")
        with open(CASE, encoding="utf-8") as file, open(path, "w", encoding="utf-8") as plan:
            plan.write(file.read().replace('\nend = "145 s"', f'\nend = "{end} s"'))
        return path

    def ended(self, process, code=0, seconds=60, **rest):
        out, err = process.communicate(timeout=seconds * WAIT_FACTOR, **rest)
        self.assertEqual(process.returncode, code, out + err)
        return out, err

    def forecast(self, job_id):
        return self.client.ask("ForecastJob", id=job_id)

    def studies(self):
        return self.client.ask("ListStudies").studies

    def ensemble(self):
        """A study of 31 runs of the plan with other data, the fewest that its 28 data permit."""
        out, _ = self.ended(self.dccast("uncertainty", CASE, "--set", f"time.end={END} s", "--runs", "31",
                                        "--json"), seconds=120)
        return json.loads(out)["study"]["id"]

    def study_of_one_key(self):
        self.ended(self.dccast("sweep", self.case_file(end=4), "--no-wait", "--grid",
                               "schedule.hold=50 s,60 s"))
        return self.studies()[0].id

    def until_time(self, job_id, time_s):
        def reached():
            job = self.client.job(job_id)
            return job.HasField("last_step") and job.last_step.time_s >= time_s
        until(reached, 30)


class Record(FollowTest):
    def test_a_job_goes_as_far_as_its_readings_and_ends_with_them(self):
        job_id = self.follow()
        first = readings(end=-40)
        kept = self.append(job_id, *first)
        self.assertEqual((kept.number, kept.time_s, kept.closed), (21, -40, False))
        self.until_time(job_id, -44)

        def waits():
            job = self.client.job(job_id)
            return job.state == job_pb2.RUNNING and job.last_step.time_s <= -40
        stays(waits, 0.5)

        self.append(job_id, *readings(begin=-39, end=20, first=22))
        self.append(job_id, follow_pb2.Reading(number=82, closes=True))
        steps = self.steps_at_end(job_id)
        self.assertLessEqual(steps[-1].time_s, 20)
        self.assertGreater(steps[-1].time_s, 15)

        # Trapezia between the readings: 10 s at 0.9 of 40 mm/min, a second up from none, and so on.
        measured = numpy.array([(r.time_s, r.casting_speed_m_per_s) for r in readings(end=20)])
        times = numpy.linspace(-60, steps[-1].time_s, 200001)
        length = numpy.trapz(numpy.interp(times, *measured.T), times)
        self.assertAlmostEqual(steps[-1].cast_length_m, length, delta=1e-8)

    def test_readings_count_once_and_in_order(self):
        job_id = self.follow()
        made = readings()
        self.append(job_id, *made[:10])
        self.assertEqual(self.append(job_id, *made[:12]).number, 12)
        self.assertEqual(self.append(job_id).number, 12)
        self.refused(grpc.StatusCode.OUT_OF_RANGE, self.append, job_id, made[13])

        back = follow_pb2.Reading(number=13, time_s=-70)
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.append, job_id, back)
        nothing = follow_pb2.Reading(number=13, time_s=float("nan"))
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.append, job_id, nothing)
        self.assertEqual(self.append(job_id).number, 12)

        self.append(job_id, follow_pb2.Reading(number=13, closes=True))
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.append, job_id,
                     follow_pb2.Reading(number=14, time_s=0))

    def test_a_value_that_no_plant_has_is_left_out_alone(self):
        """Broken sensors of every column, in one call: the casting is that of the other values."""
        job_id = self.follow(gauges=[follow_pb2.Gauge(monitor="corner", noise_m=1e-3)])
        wrong = {"casting_speed_m_per_s": (0.5461, -9999 / 6e4), "water_flow_m2_per_s": (0.16665, -1e-3),
                 "narrow_water_flow_m2_per_s": (1.0, float("nan")),
                 "casting_temperature_c": (-9999.0, 32767.0)}
        made = readings()
        broken = dict(zip(range(5, 13), ((name, value) for name, values in wrong.items()
                                         for value in values)))
        for place, (name, value) in broken.items():
            setattr(made[place], name, value)
        made[20].curls.add(monitor="corner", curl_m=32.767)
        kept = self.append(job_id, *made)
        self.assertEqual((kept.number, kept.time_s), (len(made), END))
        self.assertEqual([(each.number, each.name) for each in kept.left_out],
                         [(place + 1, name) for place, (name, _) in broken.items()]
                         + [(21, "corner_curl_m")])
        self.assertIn("the casting speed is 0.5461 m/s; permitted: 0 to 0.1 m/s", kept.left_out[0].reason)
        self.assertIn("permitted: 0 to 2000 degC", kept.left_out[-2].reason)
        self.assertIn("the curl is 32.767 m; permitted: -1 to 1 m", kept.left_out[-1].reason)

        # The values beside them count, and a gap of a second is bridged.
        steps = self.steps_at_end(job_id)
        self.assertAlmostEqual(steps[-1].time_s, END)
        times = numpy.linspace(-60, END, 200001)
        sound = [(r.time_s, r.casting_speed_m_per_s) for i, r in enumerate(readings())]
        length = numpy.trapz(numpy.interp(times, *numpy.array(sound).T), times)
        self.assertAlmostEqual(steps[-1].cast_length_m, length, delta=1e-8)

    def test_a_value_that_this_casting_cannot_have_is_left_out_and_explained(self):
        """The metal in K or degF, 0 degC of a broken wire, rates of another unit: by alloy and plan."""
        explained = {"casting_temperature_c": {953.15: "if the sensor shows K, it is 680 degC",
                                               1256.0: "if the sensor shows degF, it is 680 degC",
                                               68.0: "it is a tenth, it is 680 degC",
                                               0.0: "from the solidus to 150 K above plan and liquidus",
                                               1372.0: "from the solidus to 150 K above plan and liquidus"},
                     "casting_speed_m_per_s": {-40e-3 / 60: "its sign is turned",
                                               400e-3 / 60: "it is ten times too large",
                                               40e-3: "what is read per second is per minute"},
                     "water_flow_m2_per_s": {20e-3: "it is ten times too large"}}
        job_id = self.follow()
        made = readings()
        wrong = [(name, value, text) for name, texts in explained.items() for value, text in texts.items()]
        for place, (name, value, _) in enumerate(wrong):
            setattr(made[2 * place], name, value)
        left_out = self.append(job_id, *made).left_out
        self.assertEqual([(each.number, each.name, each.value) for each in left_out],
                         [(2 * place + 1, name, value) for place, (name, value, _) in enumerate(wrong)])
        for each, (_, _, text) in zip(left_out, wrong):
            self.assertIn(text, each.reason)
        self.assertAlmostEqual(self.steps_at_end(job_id)[-1].time_s, END)

    def test_a_sensor_whose_zero_drifts_shows_zero(self):
        job_id = self.follow()
        made = readings()
        for reading in made[:40]:
            reading.casting_speed_m_per_s = -4.9e-3 / 60
            reading.water_flow_m2_per_s = -0.3e-3 / 60
        self.assertFalse(self.append(job_id, *made).left_out)
        self.assertEqual(self.append(job_id).number, len(made))
        job_id = self.follow()
        beyond = follow_pb2.Reading(number=1, time_s=-60, casting_speed_m_per_s=-5.1e-3 / 60,
                                    water_flow_m2_per_s=-5.1e-3 / 60)
        self.assertEqual(len(self.append(job_id, beyond).left_out), 2)

    def test_a_running_job_tells_how_far_the_casting_has_been_measured(self):
        job_id = self.follow()
        self.client.until_state(job_id, job_pb2.RUNNING)
        self.assertFalse(self.client.job(job_id).casting.HasField("measured"))

        made = readings(end=10)
        made[-1].ClearField("water_flow_m2_per_s")  # the last value holds for 10 s
        begin = time.time()
        self.append(job_id, *made)
        casting = self.client.job(job_id).casting
        self.assertLessEqual(casting.age_s, time.time() - begin)
        measured, planned = casting.measured, casting.planned
        self.assertEqual((measured.time_s, planned.time_s, casting.closed), (10, 10, False))
        self.assertAlmostEqual(measured.casting_speed_m_per_s, levers(10)[0])
        self.assertAlmostEqual(measured.water_flow_m2_per_s, levers(9)[1])
        self.assertAlmostEqual(planned.casting_speed_m_per_s, 40e-3 / 60)
        self.assertAlmostEqual(planned.water_flow_m2_per_s, 1.5e-3)
        self.assertAlmostEqual(planned.casting_temperature_c, 680)
        self.assertFalse(planned.HasField("narrow_water_flow_m2_per_s"))

        # The record knows when its last reading arrived.
        self.daemon.kill_with_workers()
        self.restart()
        self.client.until_state(job_id, job_pb2.RUNNING)
        listed = self.client.ask("ListJobs").jobs[0].casting
        self.assertEqual(listed.measured, measured)
        self.assertLess(abs(listed.age_s - (time.time() - begin)), 1.0)

        self.append(job_id, follow_pb2.Reading(number=72, closes=True))
        self.client.until_state(job_id, job_pb2.SUCCEEDED)
        self.assertFalse(self.client.job(job_id).HasField("casting"))

    def test_other_jobs_and_ended_ones_take_no_readings(self):
        with open(CASE, encoding="utf-8") as file:
            case = self.client.ask("ReadCase", text=file.read()).case
        plain = self.client.submit(case).id
        error = self.refused(grpc.StatusCode.FAILED_PRECONDITION, self.append, plain, *readings()[:1])
        self.assertIn("dccast follow", error.details())

        job_id = self.follow()
        self.append(job_id, *readings())
        self.steps_at_end(job_id)
        self.assertEqual(self.append(job_id).number, len(readings()))
        self.refused(grpc.StatusCode.FAILED_PRECONDITION, self.append, job_id,
                     follow_pb2.Reading(number=200, time_s=200))

    def test_pause_cancel_and_deletion_work_while_it_waits(self):
        job_id = self.follow()
        self.append(job_id, *readings(end=-30))
        self.until_time(job_id, -35)
        self.client.ask("PauseJob", id=job_id)
        self.client.until_state(job_id, job_pb2.PAUSED)
        self.append(job_id, *readings(begin=-29, first=32))
        self.client.ask("ResumeJob", id=job_id)
        self.steps_at_end(job_id)

        waiting = self.follow()
        self.client.until_state(waiting, job_pb2.RUNNING)
        self.client.cancel(waiting)
        self.client.until_state(waiting, job_pb2.CANCELLED)
        self.client.ask("DeleteJob", id=waiting)


class Kills(FollowTest):
    def test_kills_of_worker_and_daemon_lose_nothing_and_use_nothing_twice(self):
        undisturbed = self.follow()
        made = readings()
        self.append(undisturbed, *made)
        expected = physics(self.steps_at_end(undisturbed))

        shots = random.Random(4)
        job_id = self.follow()
        sent = 0
        while sent < len(made):
            count = shots.randint(1, 12)
            sent = self.append(job_id, *made[sent:sent + count]).number
            shot = shots.choice(["worker", "daemon", "none", "daemon and worker"])
            if shot == "worker":
                for worker in self.daemon.worker_processes():
                    os.kill(worker, signal.SIGKILL)
            elif shot == "daemon":
                self.daemon.kill()
                self.restart()
            elif shot == "daemon and worker":
                self.daemon.kill_with_workers()
                self.restart()
            self.assertEqual(self.append(job_id).number, sent)
        self.assertEqual(physics(self.steps_at_end(job_id)), expected)

    def test_a_torn_reading_was_not_acknowledged_and_is_sent_again(self):
        job_id = self.follow()
        made = readings()
        self.append(job_id, *made[:20])
        self.daemon.kill_with_workers()
        path = self.in_folder("data", "jobs", job_id, "readings.log")
        with open(path, "r+b") as record:
            record.truncate(os.path.getsize(path) - 3)
        self.restart()
        self.assertEqual(self.append(job_id).number, 19)
        self.append(job_id, *made[19:])
        self.steps_at_end(job_id)


class Forecast(FollowTest):
    def test_a_measured_curl_tells_the_curl_to_come(self):
        """The hidden casting is one of another seed: what its curl shows narrows the ensemble."""
        studies = [self.study(seed, runs) for seed, runs in ((0, 31), (9, 31))]
        request = study_pb2.EvaluateStudyRequest(id=studies[1], curves=True)
        run = self.client.stub.EvaluateStudy(request, timeout=30).runs[0]
        curve = next(each for each in run.curves if each.monitor == "corner")

        gauge = follow_pb2.Gauge(monitor="corner", noise_m=5e-4)
        job_id = self.follow(ensemble=studies[0], gauges=[gauge])
        before = self.forecast(job_id).curls[0]
        self.assertEqual((before.members, before.readings), (31, 0))

        self.append(job_id, *[
            follow_pb2.Reading(number=t + 1, time_s=t, curls=[follow_pb2.MeasuredCurl(
                monitor="corner",
                curl_m=numpy.interp(t, curve.time_s, numpy.nan_to_num(curve.curl_m)))])
            for t in range(0, 26)])
        after = self.forecast(job_id).curls[0]
        self.assertEqual((after.readings, after.left_out, after.time_s[0]), (26, 0, 25))
        end = numpy.interp(after.time_s[-1], curve.time_s, curve.curl_m)
        width = lambda curl: curl.upper_m[-1] - curl.lower_m[-1]
        self.assertLess(abs(after.curl_m[-1] - end), 0.8 * width(after))
        self.assertLess(width(after), 0.8 * width(before))

        shown = self.run_dccast("forecast", job_id).stdout
        self.assertIn("26 readings, 0 left out; 31 members", shown)

    def test_a_plan_that_is_not_prepared_is_forecast_by_its_run_and_the_last_difference(self):
        plan = self.case_file(end=20)
        path = self.in_folder("curls.csv")
        with open(path, "w", encoding="utf-8") as file:
            file.write("time [s], curl corner [mm]\n")
            file.writelines(f"{t}, {1.5 + 0.01 * max(t, 0)}\n" for t in range(-60, 11))
        words = ("follow", plan, "--readings", path)
        _, err = self.ended(self.dccast(*words))
        self.assertIn("this plan is not prepared: the forecast is its run", err)
        run, followed = self.run_of_plan_and_job()
        self.assertEqual(run.priority, job_pb2.HIGH)
        self.client.until_state(run.id, job_pb2.SUCCEEDED)

        steps = self.client.ask("QueryResult", id=run.id).steps
        last = max(step.time_s for step in steps)
        computed = numpy.array([(step.time_s, step.monitors[0].curl_m) for step in steps]).T
        whole = self.forecast(followed.id)
        curl = whole.curls[0]
        self.assertEqual((curl.members, curl.time_s[0]), (0, 10))
        difference = 1.6e-3 - numpy.interp(10, *computed)
        self.assertAlmostEqual(curl.curl_m[-1], numpy.interp(last, *computed) + difference, delta=5e-4)
        self.assertGreater(curl.upper_m[-1], curl.curl_m[-1])
        self.assertIn("was not prepared", whole.notes[0])

        shown = self.ended(self.dccast("forecast", followed.id))[0]
        self.assertIn("the run of the plan alone", shown)
        self.assertIn("--prepare", shown)

        # The next casting of this plan finds the run again.
        self.ended(self.dccast(*words))
        jobs = self.client.ask("ListJobs").jobs
        self.assertEqual(len(jobs), 3)

    def test_levers_that_left_the_plan_act_in_the_forecast(self):
        """Before a curl is measured the forecast is the mean of the ensemble, and what they have done."""
        plan = self.finished_draft(END)
        gauge = follow_pb2.Gauge(monitor="corner", noise_m=5e-4)
        basis = {"ensemble": self.study(0, 31), "gauges": [gauge]}
        followed = [self.follow(plan_job=run, **basis) for run in (plan, "")]
        for job_id in followed:
            self.append(job_id, *readings(end=30))
            self.until_time(job_id, 29)

        with_run, without = (self.forecast(job_id) for job_id in followed)
        curve = lambda job_id: numpy.array([(step.time_s, step.monitors[0].curl_m)
                                            for step in self.client.steps(job_id)]).T
        last = curve(followed[0])[0, -1]
        done = numpy.interp(last, *curve(followed[0])) - numpy.interp(last, *curve(plan))
        self.assertGreater(abs(done), 1e-5)
        for shown, planned in zip(with_run.curls[0].curl_m, without.curls[0].curl_m):
            self.assertAlmostEqual(shown - planned, done, delta=1e-9)
        width = lambda whole: whole.curls[0].upper_m[-1] - whole.curls[0].lower_m[-1]
        self.assertGreater(width(with_run), width(without))

    def run_of_plan_and_job(self):
        jobs = self.client.ask("ListJobs").jobs
        is_run = lambda job: any(label.startswith("plan=") for label in job.labels)
        return (next(job for job in jobs if is_run(job)),
                next(job for job in jobs if not is_run(job)))

    def test_a_job_without_an_ensemble_has_no_forecast(self):
        error = self.refused(grpc.StatusCode.FAILED_PRECONDITION, self.forecast, self.follow())
        self.assertIn("measures no curl", error.details())
        gauge = follow_pb2.Gauge(monitor="corner", noise_m=1e-3)
        without = self.follow(gauges=[gauge])
        error = self.refused(grpc.StatusCode.FAILED_PRECONDITION, self.forecast, without)
        self.assertIn("dccast follow --prepare", error.details())

        gauge = follow_pb2.Gauge(monitor="cornr", noise_m=1e-3)
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.follow, gauges=[gauge])
        gauge = follow_pb2.Gauge(monitor="corner", noise_m=0)
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.follow, gauges=[gauge])
        nobody = "00000000-0000-4000-8000-000000000000"
        self.refused(grpc.StatusCode.NOT_FOUND, self.follow, ensemble=nobody)
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.follow, pairs=nobody)
        self.assertIn("without an ensemble", error.details())

    def study(self, seed, runs):
        self.run_dccast("uncertainty", CASE, "--set", f"time.end={END} s", "--runs", str(runs),
                        "--seed", str(seed), "--json")
        return self.studies()[0].id


class Preparation(FollowTest):
    def table_of_curls(self):
        path = self.in_folder("curls.csv")
        with open(path, "w", encoding="utf-8") as file:
            file.write("time [s], curl corner [mm]\n")
            file.writelines(f"{t}, {max(t, 0) * 0.05}\n" for t in range(-60, 5))
        return path

    def followed(self, *words):
        """A job that follows a casting of the plan, what was said, and its forecast."""
        process = self.dccast("follow", self.case_file(end=4), "--readings", self.table_of_curls(),
                              "--set", "quality=draft", *words)
        _, err = self.ended(process)
        return self.client.ask("ListJobs").jobs[0].id, err

    def test_a_prepared_plan_is_found_again_by_its_case(self):
        plan = self.case_file(end=4)
        _, err = self.followed()
        self.assertIn("is not prepared", err)

        _, err = self.ended(self.dccast("follow", "--prepare", plan), seconds=300)  # 184 runs
        self.assertIn("the plan is prepared", err)
        levers, pairs, ensemble = self.studies()
        self.assertEqual((ensemble.runs, pairs.runs, levers.runs), (64, 16, 104))
        request = study_pb2.EvaluateStudyRequest(id=pairs.id)
        self.assertEqual(self.client.stub.EvaluateStudy(request, timeout=30).runs[0].values,
                         self.client.ask("EvaluateStudy", id=ensemble.id).runs[0].values)
        self.ended(self.dccast("follow", "--prepare", plan, "--set", "quality=fine",
                               "--set", "title=pit 3"))
        self.assertEqual(len(self.studies()), 3, "quality and title of the case do not count")

        paired, err = self.followed()
        self.assertNotIn("is not prepared", err)
        self.assertIn("what can still be done: no lever lowers the corner by more than 1 mm any more",
                      self.ended(self.dccast("forecast", paired))[0])
        by_band, _ = self.followed("--ensemble", ensemble.id)
        paired, by_band = self.forecast(paired), self.forecast(by_band)
        self.assertGreaterEqual(paired.curls[0].members, 60)
        self.assertNotAlmostEqual(paired.curls[0].curl_m[-1], by_band.curls[0].curl_m[-1], delta=1e-9)

        other = self.study_of_one_key()
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.follow, ensemble=ensemble.id,
                             pairs=other)
        self.assertIn("over other keys", error.details())


class Advice(FollowTest):
    """What can still be done, from drafts with a lever moved from some time of the casting on."""

    END = 10  # s of casting: a levers study has 104 runs

    def case(self):
        with open(self.case_file(self.END), encoding="utf-8") as file:
            return self.client.ask("ReadCase", text=file.read()).case

    def levers(self):
        created = self.client.ask("CreateStudy", request_id="levers", case=self.case(),
                                  levers=study_pb2.LeversPlan())
        until(lambda: all(s.state != study_pb2.STUDY_RUNNING for s in self.studies()), 180)
        return self.client.ask("EvaluateStudy", id=created.id, curves=True)

    def test_levers_are_compared_with_the_plan_at_equal_cast_length(self):
        study = self.levers()
        self.assertEqual(len(study.runs), 8 * 13)
        corner = list(study.monitors).index("corner")
        curve_of = lambda run: next(c for c in run.curves if c.monitor == "corner")
        plan_of, moved = None, []
        for run, effect in zip(study.runs, study.lever_effects):
            self.assertEqual(run.lever_step, effect.step)
            if not effect.HasField("step"):
                plan_of = run
                self.assertAlmostEqual(effect.curl_m[corner], run.end_curl_m[corner], delta=1e-9)
                continue
            moved.append((plan_of.end_curl_m[corner], effect))
            plan, other = curve_of(plan_of), curve_of(run)
            length = min(plan.cast_length_m[-1], other.cast_length_m[-1])
            self.assertAlmostEqual(length, plan.cast_length_m[-1], delta=1e-4)
            at = lambda c: numpy.interp(length, c.cast_length_m, numpy.nan_to_num(c.curl_m))
            # Lengths that differ by less than a micrometre are equal.
            self.assertAlmostEqual(effect.curl_m[corner], at(other) - at(plan), delta=2e-7)
            # Up to the step in which the lever is moved, of 0.5 s, the casting is that of the plan.
            before = numpy.arange(0, run.lever_step.from_s - 0.5, 0.1)
            then = lambda c: numpy.interp(before, c.time_s, numpy.nan_to_num(c.curl_m))
            self.assertLess(numpy.max(numpy.abs(then(other) - then(plan))), 1e-7)

        job = self.client.submit(self.case())
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        gauge = follow_pb2.Gauge(monitor="corner", noise_m=1e-3)
        followed = self.follow(self.END, plan_job=job.id, levers=study.study.id, gauges=[gauge])
        begins = sorted({effect.step.from_s for _, effect in moved})
        self.assertEqual(begins, [0.1 * self.END, 0.25 * self.END])
        for number, time_s in enumerate(begins, 1):
            self.append(followed, follow_pb2.Reading(number=number, time_s=time_s))
            forecast = self.forecast(followed)
            self.assertEqual(len(forecast.levers), 6)
            for lever in forecast.levers:
                now = [(curl, e.curl_m[corner]) for curl, e in moved
                       if (e.step.words, e.step.from_s) == (lever.words, time_s)]
                line = numpy.polyfit(*numpy.array(now).T, 1)
                self.assertAlmostEqual(lever.curls[0].curl_m,
                                       numpy.polyval(line, forecast.curls[0].curl_m[-1]), delta=1e-9)
            self.assertTrue(forecast.advice)
        shown = self.ended(self.dccast("forecast", followed))[0]
        self.assertIn(f"what can still be done: {forecast.advice[0]}", shown)
        self.ended(self.dccast("studies", "show", study.study.id))

        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.follow, ensemble=study.study.id)
        self.assertIn("no runs over data", error.details())
        grid = self.study_of_one_key()
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.follow, levers=grid)
        self.assertIn("dccast follow --prepare", error.details())


class Line(FollowTest):
    """Castings on a line of which each is 20 % more than the mean of the ensemble."""

    def setUp(self):
        super().setUp()
        self.study_id = self.ensemble()
        request = study_pb2.EvaluateStudyRequest(id=self.study_id, curves=True)
        runs = self.client.stub.EvaluateStudy(request, timeout=30).runs
        curves = [next(c for c in run.curves if c.monitor == "corner") for run in runs]
        self.times = numpy.arange(0, END + 1)
        self.mean = numpy.mean([numpy.interp(self.times, c.time_s, numpy.nan_to_num(c.curl_m))
                                for c in curves], axis=0)

    def on_line(self, name="pit-3"):
        gauge = follow_pb2.Gauge(monitor="corner", noise_m=2e-4)
        return self.follow(ensemble=self.study_id, gauges=[gauge], line=name)

    def cast(self, name="pit-3"):
        """A casting on the line that has ended."""
        job_id = self.on_line(name)
        self.append(job_id, *[
            follow_pb2.Reading(number=t + 1, time_s=t, curls=[follow_pb2.MeasuredCurl(
                monitor="corner", curl_m=1.2 * self.mean[t])]) for t in self.times])
        self.client.cancel(job_id)
        self.client.until_state(job_id, job_pb2.CANCELLED)
        return job_id

    def line(self, name="pit-3"):
        return self.client.ask("GetLine", id=name)

    def test_castings_make_the_forecast_before_the_next_one_better(self):
        first = self.forecast(self.on_line()).curls[0]
        self.assertEqual(first.line.castings, 0)
        for _ in range(3):
            self.cast()
        self.daemon.kill()
        self.restart()

        after = self.on_line()
        curl = self.forecast(after).curls[0]
        self.assertEqual(curl.line.castings, 3)
        hidden = 1.2 * self.mean[-1]
        self.assertLess(abs(curl.before.curl_m - hidden), 0.5 * abs(first.before.curl_m - hidden))
        self.assertLess(curl.before.upper_m - curl.before.lower_m,
                        0.8 * (first.before.upper_m - first.before.lower_m))
        shown = self.ended(self.dccast("forecast", after))[0]
        self.assertIn("corner: before the casting", shown)
        self.assertIn("3 earlier castings on the line", shown)

        # A casting keeps its forecast: later ones do not change it.
        self.cast()
        self.assertEqual(self.forecast(after).curls[0].line.castings, 3)

        listed = self.ended(self.dccast("line", "list"))[0]
        self.assertRegex(listed, r"pit-3 +\S+ +6 ")
        shown = self.ended(self.dccast("line", "show", "pit-3"))[0]
        self.assertEqual(shown.count(f"mm at {END} s"), 4, shown)
        self.assertEqual(shown.count("has not ended"), 2, shown)

        self.ended(self.dccast("line", "restart", "pit-3"))
        self.assertFalse(self.line().castings)
        self.assertEqual(self.forecast(after).curls[0].line.castings, 0)
        self.assertEqual(self.forecast(self.on_line()).curls[0].line.castings, 0)

        _, err = self.ended(self.dccast("line", "forget", "pit-3", "--all"))
        self.assertIn("forgotten", err)
        self.refused(grpc.StatusCode.NOT_FOUND, self.line)
        self.assertFalse(self.forecast(after).curls[0].HasField("line")
                         and self.forecast(after).curls[0].line.castings)

    def test_a_casting_tells_its_curl_before_its_job_is_deleted(self):
        told = self.cast()
        self.line()  # the first one has told its curl
        for job_id in (told, self.cast()):
            self.client.ask("DeleteJob", id=job_id)
        self.assertEqual([len(c.curls) for c in self.line().castings], [1, 1])
        self.assertEqual(self.forecast(self.on_line()).curls[0].line.castings, 2)

    def test_names_and_lines_that_are_not_there(self):
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.on_line, "../pit")
        self.assertIn("the first a letter or digit", error.details())
        self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.line, "a b")
        for action in (("show", "pit-9"), ("restart", "pit-9"), ("forget", "pit-9", "--all")):
            _, err = self.ended(self.dccast("line", *action), code=5)
            self.assertIn('there is no line "pit-9"', err)
            self.assertIn("dccast line list", err)
        _, err = self.ended(self.dccast("line", "list"))
        self.assertIn("--line NAME begins one", err)

    def test_a_damaged_line_is_refused_and_can_be_forgotten(self):
        self.cast()
        path = self.in_folder("data", "lines", "pit-3.bin")
        with open(path, "r+b") as file:
            file.seek(40)
            file.write(b"\xff")
        error = self.refused(grpc.StatusCode.DATA_LOSS, self.line)
        self.assertIn("pit-3", error.details())
        self.cast("pit-4")
        out, err = self.ended(self.dccast("line", "list"))
        self.assertIn("pit-4", out)
        self.assertIn("line pit-3 is damaged", err)
        self.ended(self.dccast("line", "forget", "pit-3", "--all"))
        self.cast()


class Plant(FollowTest):
    """A simulated plant with a faulty logger: tests/verification/plant.py."""

    def test_faults_of_the_logger_are_named_and_the_casting_is_forecast(self):
        plan = self.case_file()
        self.ended(self.dccast("submit", "--watch", plan, "--set", "quality=engineering", "--set",
                               "schedule.casting_speed.scale=0.9"))
        hidden = self.newest_job()
        ensemble = self.ensemble()
        script = os.path.join(os.path.dirname(__file__), "..", "verification", "plant.py")
        plant = subprocess.Popen(
            ["/usr/bin/python3", script, hidden, "--server", self.daemon.address, "--pace", "50",
             "--zero-mm", "1", "--late", "0.05", "--doubled", "0.05", "--dropouts", "0.03", "--empty",
             "0.05"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        follow = self.dccast("follow", plan, "--set", "quality=draft", "--ensemble", ensemble, "--zero", "1 mm", stdin=plant.stdout)
        _, said = self.ended(follow)
        plant.stdout.close()
        self.assertEqual(plant.wait(timeout=30), 0)
        wrong = {fault: int(count) for count, fault in (
            part.split() for part in plant.stderr.read().split("; ")[1].split(", "))}
        plant.stderr.close()

        for fault in wrong.values():
            self.assertGreater(fault, 0, wrong)
        left_out = wrong["late"] + wrong["doubled"]
        self.assertEqual(said.count("is not later than"), 1, said)
        self.assertIn(f"lines that are not later than the one before: {left_out} in all", said)
        curl = self.forecast(self.newest_job()).curls[0]
        self.assertEqual(curl.left_out, 0)
        self.assertGreater(curl.readings, 25)
        self.assertRegex(said, r"forecast at \d+ s: corner .* mm at the end")

    def newest_job(self):
        return self.client.ask("ListJobs").jobs[0].id


class Replay(FollowTest):
    def test_a_record_is_written_at_its_pace(self):
        path = self.in_folder("casting.csv")
        with open(path, "w", encoding="utf-8") as file:
            file.write("# line 4\n" + table() + "nonsense\n")
        begin = time.monotonic()
        out, _ = self.ended(self.dccast("replay", path, "--pace", "100"))
        self.assertGreater(time.monotonic() - begin, 1.0, "100 s of casting")
        with open(path, encoding="utf-8") as file:
            self.assertEqual(out, file.read())

        slow = self.dccast("replay", path)
        for _ in range(3):
            self.assertTrue(slow.stdout.readline())
        self.assertIsNone(slow.poll(), "the second reading comes after a second")
        slow.send_signal(signal.SIGINT)
        slow.communicate(timeout=10 * WAIT_FACTOR)
        self.assertEqual(slow.returncode, 130)

    def test_a_replayed_casting_is_followed(self):
        path = self.write_file("casting.csv", table())
        plant = self.dccast("replay", path, "--pace", "50")
        follower = self.dccast("follow", self.case_file(), "--set", "quality=draft",
                               stdin=plant.stdout)
        plant.stdout.close()
        self.ended(follower)
        self.assertEqual(plant.wait(10), 0)
        plant.stderr.close()
        job = self.client.ask("ListJobs").jobs[0]
        self.assertAlmostEqual(job.last_step.time_s, END)

    def test_a_file_that_is_no_record_is_refused(self):
        for text, word in (("", "is empty"), ("colour [1]\n", "a column for the time")):
            path = self.write_file("wrong.csv", text)
            _, err = self.ended(self.dccast("replay", path), code=2)
            self.assertIn(word, err)


class Client(FollowTest):
    def test_a_recorded_casting_is_computed_again(self):
        path = self.write_file("casting.csv", table())
        process = self.dccast("follow", self.case_file(), "--set", "quality=draft", "--readings",
                              path, "--label", "casting-41", "--json")
        out, err = self.ended(process)
        self.assertIn("columns that are left out: \"operator [1]\"", err)
        events = [json.loads(line) for line in out.splitlines()]
        self.assertEqual(events[-1]["state"], "SUCCEEDED")

        direct = self.follow()
        self.append(direct, *readings())
        self.assertAlmostEqual(self.steps_at_end(direct)[-1].monitors[0].curl_m,
                               events[-1]["monitors"][0]["displacement_m"][1], delta=1e-9)

    def test_objects_with_names_of_the_plant_give_the_same_casting(self):
        columns = self.write_file("plc.toml", 'time = { name = "ts", zero = "2026-11-27T04:01:00Z" }\n'
                                  'speed = { name = "DB12.Speed", unit = "m/min" }\n'
                                  'water = { name = "FT101", unit = "m3/h", per = "5 m" }\n'
                                  'metal = { name = "TT3", unit = "K" }\n')
        zero = datetime.datetime(2026, 11, 27, 4, 1, tzinfo=datetime.timezone.utc)
        lines = []
        for reading in readings():
            moment = zero + datetime.timedelta(seconds=reading.time_s)
            lines.append(json.dumps({
                "ts": moment.isoformat(), "DB12.Speed": 60 * reading.casting_speed_m_per_s,
                "FT101": 5 * 3600 * reading.water_flow_m2_per_s,
                "TT3": reading.casting_temperature_c + 273.15, "batch": {"no": 7}}))
        process = self.dccast("follow", self.case_file(), "--set", "quality=draft", "--columns",
                              columns, "--json", stdin=subprocess.PIPE)
        out, err = self.ended(process, input="\n".join(lines) + '\n{"ts": "2026-11-\n')
        self.assertIn('columns that are left out: "batch"', err)
        self.assertIn("it is no complete JSON object", err)
        event = json.loads(out.splitlines()[-1])
        self.assertEqual(event["state"], "SUCCEEDED")

        direct = self.follow()
        self.append(direct, *readings())
        self.assertAlmostEqual(self.steps_at_end(direct)[-1].monitors[0].curl_m,
                               event["monitors"][0]["displacement_m"][1], delta=1e-9)

    def test_a_file_of_columns_that_is_wrong_makes_no_job(self):
        columns = self.write_file(
            "plc.toml", 'time = {name = "ts", unit = "s" }\nspeed = {name = "v", unit = "kg" }\n')
        process = self.dccast("follow", self.case_file(), "--columns", columns, stdin=subprocess.PIPE)
        _, err = self.ended(process, code=2, input="ts, v\n1, 2\n")
        self.assertIn("plc.toml:2:", err)
        self.assertIn("cannot be converted to m/s", err)
        self.assertFalse(self.client.ask("ListJobs").jobs)

    def test_the_client_bridges_bad_lines_and_says_so(self):
        lines = table().splitlines()
        lines[5] = "nonsense"
        lines[9] = "-52, abc, 80, 680, 3"
        lines[12] = lines[11]
        del lines[30:45]
        process = self.dccast("follow", self.case_file(), "--set", "quality=draft", "--readings", "-",
                              stdin=subprocess.PIPE)
        _, err = self.ended(process, input="\n".join(lines))
        for word in ("line 6: left out: it has 1 columns", "line 10: \"abc\" of speed [mm/min] is no number",
                     "line 13: left out: -50 s is not later than -50 s",
                     "no reading for 16 s: the plan of the case holds there"):
            self.assertIn(word, err)

    def followed(self, path, *words):
        """The end of a casting that is followed to its end, and what was said on the way."""
        process = self.dccast("follow", self.case_file(), "--set", "quality=draft", "--readings", path,
                              "--json", *words)
        out, err = self.ended(process)
        return json.loads(out.splitlines()[-1]), err

    def test_a_jump_of_the_clock_is_said_once_and_carries_no_casting_to_its_end(self):
        """A clock that is set forward and back, in numbers and stamps; a gap of the same length."""
        rows = table(end=30).splitlines()
        path = self.in_folder("casting.csv")
        zero = datetime.datetime(2026, 11, 27, 4, 1, tzinfo=datetime.timezone.utc)
        columns = self.write_file("plc.toml", 'time = { name = "ts", zero = "2026-11-27T04:01:00Z" }\n'
                                  'speed = { name = "speed [mm/min]", unit = "mm/min" }\n')
        for by, stamps in ((874, False), (-60, False), (-2, False), (3600, True), (-7200, True)):
            with open(path, "w", encoding="utf-8") as file:
                file.write(rows[0].replace("time [s]", "ts" if stamps else "time [s]") + "\n")
                for row in rows[1:]:
                    time_s, rest = row.split(",", 1)
                    rest = rest.replace("680", f"{680 + 0.01 * int(time_s):.2f}")  # no line twice
                    shown = int(time_s) + (by if int(time_s) > 5 else 0)
                    if stamps:
                        shown = (zero + datetime.timedelta(seconds=shown)).isoformat()
                    file.write(f"{shown},{rest}\n")
            step, err = self.followed(path, *(("--columns", columns) if stamps else ()))
            self.assertAlmostEqual(step["time_s"], 30, places=3, msg=err)
            self.assertEqual(err.count("the clock of the source jumps by"), 1, err)

        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(rows[:65] + [f"{t}, 40, 90, 680, 3" for t in range(30, 36)]))
        step, err = self.followed(path)
        self.assertGreater(step["time_s"], 30)
        self.assertIn("taken for a gap; if the clock jumped there: --jump-from", err)
        step, _ = self.followed(path, "--jump-from", "20 s")
        self.assertLess(step["time_s"], 15)

    def test_a_log_that_is_begun_anew_is_followed_by_its_name(self):
        """Renamed, deleted, cut, and with its columns in another order; a header each time."""
        rows = [row.rsplit(",", 1)[0] for row in table(end=30).splitlines()]
        path = self.in_folder("live.csv")
        renewals = {20: "renamed", 45: "deleted", 70: "cut", 80: "turned"}
        file = open(path, "w", encoding="utf-8", buffering=1)
        file.write(rows[0] + "\n" + rows[1] + "\n")
        process = self.dccast("follow", self.case_file(end=30), "--set", "quality=draft", "--readings",
                              path, "--growing", "--json")
        turned = False
        for number, row in enumerate(rows[2:], 2):
            how = renewals.get(number)
            if how:
                file.write("partial" if how == "renamed" else "")
                time.sleep(0.6)  # longer than between two looks of the client at its file
                if how == "renamed":
                    os.rename(path, path + ".1")
                file.close()
                if how in ("deleted", "turned"):
                    os.unlink(path)
                    time.sleep(0.5)  # so that it finds no file for a while
                turned = how == "turned"
                file = open(path, "w", encoding="utf-8", buffering=1)
                file.write((",".join(reversed(rows[0].split(","))) if turned else rows[0]) + "\n")
            file.write((",".join(reversed(row.split(","))) if turned else row) + "\n")
        out, err = self.ended(process, seconds=120)
        file.close()
        step = json.loads(out.splitlines()[-1])
        self.assertEqual(err.count("was begun anew"), 4, err)
        self.assertNotIn("no reading for", err)

        direct = self.follow(end=30)
        self.append(direct, *readings(end=30))
        self.assertAlmostEqual(self.steps_at_end(direct)[-1].cast_length_m, step["cast_length_m"],
                               delta=1e-9)

    def test_ten_seconds_without_a_line_are_said(self):
        process = self.dccast("follow", self.case_file(), "--set", "quality=draft", "--readings", "-",
                              stdin=subprocess.PIPE)
        rows = table().splitlines(keepends=True)
        process.stdin.write("".join(rows[:20]))
        process.stdin.flush()
        time.sleep(12)  # longer than the 10 s after which the client says it
        _, err = self.ended(process, input="".join(rows[20:]))
        self.assertIn("no line for 10 s; still waiting", err)
        self.assertIn("lines come again, after 1", err)

    def test_a_source_that_cannot_be_used_makes_no_job(self):
        rows = table().splitlines()
        head = "time [s], speed [mm/min], water [l/min/m], metal [degC], operator [1]"
        with_commas = "\n".join([rows[0].replace(", ", ";")]
                                + [row.replace(", ", ";").replace(".", ",") for row in rows[1:]])
        for text, word in (("time [s], colour [1]", "one for a lever"),
                           ("time [s], speed [kg]", "cannot be converted to m/s"), ("", "empty"),
                           (head, "a header and nothing after it"),
                           (with_commas, "has a decimal comma and left out: numbers have a point"),
                           (table().replace(", ", ";").replace(";", ",").replace(".", ","),
                            "numbers have a point, not a decimal comma"),
                           ("\n".join([rows[0]] + ["10/25/2026 12:" + row for row in rows[1:]]),
                            "is no number and left out"),
                           ('{"time [s]": 1, "speed [mm/min]": 2, "speed [mm/min]": 3}\n', "is there twice"),
                           (head + "\n" + 20 * "a, b, c, d, e\n", "no value that can be read")):
            process = self.dccast("follow", self.case_file(), stdin=subprocess.PIPE)
            _, err = self.ended(process, code=2, input=text + ("\n" if text else ""))
            self.assertIn(word, err)
        utf16 = self.in_folder("utf16.csv")
        with open(utf16, "w", encoding="utf-16") as file:
            file.write(table())
        _, err = self.ended(self.dccast("follow", self.case_file(), "--readings", utf16), code=2)
        self.assertIn("UTF-16", err)
        self.assertFalse(self.client.ask("ListJobs").jobs)

    def test_a_broken_sensor_costs_its_own_values_and_is_named_once(self):
        lines = table().splitlines()
        for number in range(30, 60):
            cells = lines[number].split(", ")
            cells[2], cells[3] = "32767", "-9999" if number % 2 else "NaN"
            lines[number] = ", ".join(cells)
        path = self.write_file("broken.csv", "\ufeff" + ",\n".join(lines) + ",\n")
        _, err = self.ended(self.dccast("follow", self.case_file(), "--set", "quality=draft", "--readings",
                                        path))
        self.assertIn("line 31, -31 s: the water flow is 0.546117 m2/s; permitted: 0 to 0.1 m2/s", err)
        self.assertIn("line 32, -30 s: the casting temperature is -9999 degC", err)
        self.assertIn("line 31: \"NaN\" of metal [degC] is no number and left out", err)
        self.assertIn("water_flow_m2_per_s: 30 values were left out", err)
        self.assertEqual(err.count("permitted: 0 to 0.1 m2/s"), 1, err)
        job = self.client.ask("ListJobs").jobs[0]
        self.assertAlmostEqual(job.last_step.time_s, END)

    def test_a_casting_of_which_nothing_was_measured_is_no_success(self):
        lines = ["time [s], speed [mm/min], water [l/min/m], metal [degC]"]
        lines += [f"{t}, 32767, 32767, -9999" for t in range(-60, END + 1)]
        process = self.dccast("follow", self.case_file(), "--set", "quality=draft", "--readings", "-",
                              stdin=subprocess.PIPE)
        _, err = self.ended(process, code=2, input="\n".join(lines))
        self.assertIn("no value that was measured was used", err)

    def test_a_killed_client_and_a_restarted_daemon_lose_nothing(self):
        lines = table().splitlines(keepends=True)
        first, job_id, state = self.begin_live(lines[:40])
        first.kill()
        first.communicate(timeout=10)

        second = self.dccast("follow", "--job", job_id, stdin=subprocess.PIPE, env=os.environ | state)
        second.stdin.write("".join(lines[:60]))
        second.stdin.flush()
        until(lambda: self.append(job_id).number >= 59, 20)
        self.daemon.kill()
        second.stdin.write("".join(lines[60:70]))
        second.stdin.flush()
        self.restart()
        second.stdin.write("".join(lines[70:]))
        _, err = self.ended(second)
        self.assertIn("39 readings are on the server already", err)
        self.assertEqual(self.append(job_id).number, len(lines))  # readings, and the end
        self.assertAlmostEqual(self.client.job(job_id).last_step.time_s, END)

    def kept_file(self, job_id):
        return self.in_folder("state", "dccast", "readings", job_id)

    def begin_live(self, lines):
        """A client that follows live, whose readings so far are on the server."""
        state = {"XDG_STATE_HOME": self.in_folder("state")}
        client = self.dccast("follow", self.case_file(), "--set", "quality=draft", stdin=subprocess.PIPE,
                             env=os.environ | state)
        self.write(client, lines)
        until(lambda: self.client.ask("ListJobs").jobs, 30)
        job_id = self.client.ask("ListJobs").jobs[0].id
        until(lambda: self.append(job_id).number >= len(lines) - 1, 20)
        until(lambda: not os.path.exists(self.kept_file(job_id))
              or os.path.getsize(self.kept_file(job_id)) == 0, 10)
        return client, job_id, state

    @staticmethod
    def text_of(path):
        if not os.path.exists(path):
            return ""
        with open(path, encoding="utf-8") as file:
            return file.read()

    @staticmethod
    def write(client, lines):
        client.stdin.write("".join(lines))
        client.stdin.flush()

    def test_a_server_that_is_away_for_long_loses_nothing(self):
        """Longer than a watch lasts by itself (37 s); the client reads on, and keeps what comes."""
        lines = table().splitlines(keepends=True)
        client, job_id, _ = self.begin_live(lines[:40])
        self.daemon.kill()
        for line in lines[40:90]:
            self.write(client, [line])
            time.sleep(0.9)  # the pace of a plant: 45 s in all
        kept = self.kept_file(job_id)
        self.assertGreater(os.path.getsize(kept), 1000)
        self.assertEqual(os.stat(kept).st_mode & 0o777, 0o600)
        self.assertIsNone(client.poll())
        self.restart()
        self.write(client, lines[90:])
        _, err = self.ended(client)
        self.assertEqual(self.append(job_id).number, len(lines))
        self.assertAlmostEqual(self.client.job(job_id).last_step.time_s, END)
        self.assertEqual(err.count("the readings wait here"), 1, err)
        self.assertFalse(os.path.exists(kept))

    def test_a_client_that_is_killed_while_the_server_is_away_loses_nothing(self):
        lines = table().splitlines(keepends=True)
        client, job_id, state = self.begin_live(lines[:40])
        self.daemon.kill()
        self.write(client, lines[40:60])
        until(lambda: os.path.exists(self.kept_file(job_id))
              and os.path.getsize(self.kept_file(job_id)) > 500, 20)
        client.kill()
        client.communicate(timeout=10)
        self.restart()

        # The logger has gone on meanwhile: its next lines are later ones.
        second = self.dccast("follow", "--job", job_id, stdin=subprocess.PIPE, env=os.environ | state)
        _, err = self.ended(second, input="".join(lines[:1] + lines[60:]))
        self.assertIn("20 readings were kept in", err)
        self.assertEqual(self.append(job_id).number, len(lines))
        self.assertAlmostEqual(self.client.job(job_id).last_step.time_s, END)
        self.assertFalse(os.path.exists(self.kept_file(job_id)))

    def start_anew_after_a_jump(self, reads_again):
        """The clock of the logger was set forward before its client was killed."""
        head, *rows = table().splitlines(keepends=True)
        lines = [head]
        for row in rows:
            time_s, rest = row.split(",", 1)
            lines.append(f"{int(time_s) + (874 if int(time_s) > -40 else 0)},{rest}")
        first, job_id, state = self.begin_live(lines[:40])
        clock = pathlib.Path(self.kept_file(job_id) + ".clock")
        mode = clock.stat().st_mode & 0o777 if clock.exists() else None
        first.kill()
        first.communicate(timeout=10)

        second = self.dccast("follow", "--job", job_id, stdin=subprocess.PIPE, env=os.environ | state)
        _, err = self.ended(second, input="".join(lines if reads_again else lines[:1] + lines[40:]))
        self.assertAlmostEqual(self.append(job_id).time_s, END, msg=err)
        self.assertEqual(self.append(job_id).number, len(lines), err)
        self.assertIn("the clock of the source had jumped by +874 s in all", err)
        self.assertNotIn("the clock of the source jumps", err)
        self.assertEqual(mode, 0o600)
        self.assertFalse(clock.exists())

    def test_a_client_that_is_started_anew_reads_on_behind_a_jump_of_the_clock(self):
        self.start_anew_after_a_jump(reads_again=False)

    def test_a_client_that_is_started_anew_reads_a_file_with_a_jump_again(self):
        self.start_anew_after_a_jump(reads_again=True)

    def test_who_leaves_while_the_server_is_away_is_told_how_to_go_on(self):
        lines = table().splitlines(keepends=True)
        client, job_id, _ = self.begin_live(lines[:40])
        self.daemon.kill()
        self.write(client, lines[40:60])
        until(lambda: os.path.exists(self.kept_file(job_id))
              and os.path.getsize(self.kept_file(job_id)) > 500, 20)
        client.send_signal(signal.SIGINT)
        _, err = self.ended(client, code=130)
        last = err.strip().splitlines()[-1]
        self.assertIn("20 readings are kept for the server", last)
        self.assertIn(f"dccast follow --job {job_id}", last)
        self.assertGreater(os.path.getsize(self.kept_file(job_id)), 500)

    def test_a_lever_off_its_plan_is_an_alarm_and_the_advice_is_to_bring_it_back(self):
        head, *rows = table().splitlines(keepends=True)
        path = self.in_folder("casting.csv")
        told = self.in_folder("told")
        for column, value, word in ((2, "0", "ALARM at 13 s, water: the water is off: 0 l/min/m, the plan has"),
                                    (1, "0", "ALARM at 17 s, casting speed: the block stands"),
                                    (1, "4", "the unit of its column; if it is a tenth"),
                                    (3, "650", "ALARM at 17 s, metal: 650 degC, the plan has 680 degC")):
            with open(path, "w", encoding="utf-8") as file:
                file.write(head)
                for row in rows:
                    cells = row.split(", ")
                    cells[1:3] = ["40" if float(cells[0]) > 0 else "0", "90"]
                    if float(cells[0]) >= 12:
                        cells[column] = value
                    file.write(", ".join(cells))
            client = self.dccast("follow", self.case_file(end=145), "--set", "quality=draft", "--readings", path,
                                 "--growing", "--notify", f"echo $DCCAST_ALARM >> {told}")
            until(lambda: word in self.text_of(told), 30)
            job = self.client.ask("ListJobs").jobs[0]
            self.assertEqual(len(job.casting.alarms), 1)
            client.send_signal(signal.SIGINT)
            _, err = self.ended(client, code=130)
            self.assertIn(word, err)
            self.client.cancel(job.id)
            os.remove(told)

    def test_without_water_no_finding_says_cast_slower(self):
        """The shell of a casting melts without its water: the advice is to bring the water back."""
        job_id = self.follow(end=END)
        made = readings()
        for reading in made:
            if reading.time_s >= 12:
                reading.water_flow_m2_per_s = 0.0
                reading.casting_speed_m_per_s = 2.4e-3
        self.append(job_id, *made)
        self.append(job_id, follow_pb2.Reading(number=len(made) + 1, closes=True))
        until(lambda: self.client.job(job_id).state in (job_pb2.SUCCEEDED, job_pb2.FAILED), 60)
        job = self.client.job(job_id)
        late = [finding for finding in job.findings if finding.time_s > 13]
        self.assertTrue(late, job)
        for finding in late:
            self.assertIn("bring the water back to its plan", finding.remedy)
        for finding in job.findings:
            self.assertFalse(finding.time_s > 13 and "slower" in finding.remedy)


if __name__ == "__main__":
    main()
