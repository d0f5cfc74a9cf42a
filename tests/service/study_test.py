#!/usr/bin/python3
"""A refinement study from the case file to the report, on the real solver: its figures against the
curves of its jobs, picked up after the client was killed, and with a level that is lost."""
import json
import math
import os
import re
import signal
import subprocess

import h5py

from dccast.v1 import job_pb2
from support import ServiceTest, main
from waiting import until

CASE = os.path.join(os.path.dirname(__file__), "..", "..", "cases", "start-2d-thickness.toml")

# The shipped thickness section on few cells and for a short time: three levels in 2 s of computing. With
# the element that locks: its error is large enough to show an order on so few cells.
COARSE = ((r"(?s)^\[mesh\].*?(?=^\[)",
           '[mesh]\nelement = "q1"\ncolumns = 8\nrows = 6\nside_cell = "12 mm"\n'
           'bottom_cell = "12 mm"\ngrowth_cell = "12 mm"\n\n'), (r'^end = "145 s"$', 'end = "20 s"'))


def at(instant, time, values):
    """Linear between the points; instants of coarse steps are instants of fine ones but for
    round-off."""
    for i, t in enumerate(time):
        if abs(t - instant) < 1e-6:
            return values[i]
        if t > instant:
            part = (instant - time[i - 1]) / (t - time[i - 1])
            return values[i - 1] + part * (values[i] - values[i - 1])
    raise AssertionError(f"no curve at {instant} s")


def extrapolated(time, curves):
    """Order, limit and uncertainty of the last three curves, after server/studies/extrapolation.hpp."""
    coarse, middle, fine = ([at(t, *curve) for t in time] for curve in curves[-3:])
    d1 = [b - a for a, b in zip(coarse, middle)]
    d2 = [b - a for a, b in zip(middle, fine)]
    weight = [time[1] - time[0]] + [b - a for a, b in zip(time, time[1:])]
    ratio = (sum(w * a * b for w, a, b in zip(weight, d1, d2))
             / sum(w * a * a for w, a in zip(weight, d1)))
    if not 0 < ratio < 1:
        largest = [max(abs(x) for x in d1[:i + 1] + d2[:i + 1]) for i in range(len(time))]
        return None, fine, [1.25 * x for x in largest]
    order = -math.log2(ratio)
    c = 1 / (2 ** min(max(order, 0.5), 1.0) - 1)
    return (order, [f + c * ratio * a for f, a in zip(fine, d1)],
            [1.25 * c * max(abs(b), abs(ratio * a)) for a, b in zip(d1, d2)])


class RefinementStudy(ServiceTest):
    worker = "dccast-worker"
    settings = {"workers__count": 1, "workers__restarts": 0}

    def study(self, *words, code=0):
        """`dccast convergence --json`: what it found, and its messages."""
        ended = self.run_dccast("convergence", "--json", *words, code=code)
        return json.loads(ended.stdout), ended.stderr

    @staticmethod
    def limit(found, monitor):
        """The curve of the limit of a monitor."""
        return next(limit["curve"] for limit in found["limits"]
                    if limit["curve"]["monitor"] == monitor)

    def case_file(self, more=()):
        path = self.in_folder("case.toml")
        with open(CASE, encoding="utf-8") as shipped:
            text = shipped.read()
        for pattern, other in (*COARSE, *more):
            text, changes = re.subn(pattern, other, text, flags=re.M)
            self.assertGreater(changes, 0, pattern)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def begin_study(self, path):
        """A client that has begun a study. Returns it and the study's id."""
        client = subprocess.Popen(self.client_command("convergence", path), stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end, client)
        return client, re.match(r"study ([0-9a-f-]{36})\b", client.stderr.readline())[1]

    @staticmethod
    def end(client):
        if client.poll() is None:
            client.kill()
        client.wait()
        client.stderr.close()

    def jobs_of(self, study):
        return list(self.client.ask("ListJobs", study=study).jobs)

    def curve(self, job_id, monitor):
        steps = self.client.steps(job_id)
        values = [next(m.displacement_m[1] for m in step.monitors if m.name == monitor)
                  for step in steps]
        return [step.time_s for step in steps], values

    def assert_close(self, found, expected):
        self.assertEqual(len(found), len(expected))
        for a, b in zip(found, expected):
            self.assertAlmostEqual(a, b, delta=1e-12)

    def test_the_figures_are_those_of_the_jobs(self):
        found, said = self.study(self.case_file())
        self.assertRegex(said, r"3 runs, roughly \d+.* of computing\n")
        levels = found["runs"]
        self.assertEqual([level["refinement"] for level in levels], [1, 2, 4])
        nodes = [level["nodes"] for level in levels]
        self.assertEqual(nodes, sorted(set(nodes)))
        self.assertEqual({job.id for job in self.jobs_of(found["study"]["id"])},
                         {level["job"] for level in levels})
        self.assertEqual(found["monitors"], ["corner", "mid", "centre"])
        for place, (monitor, limit) in enumerate(zip(found["monitors"], found["limits"])):
            curve = limit["curve"]
            self.assertEqual(curve["monitor"], monitor)
            curves = [self.curve(level["job"], monitor) for level in levels]
            self.assertEqual([level["end_curl_m"][place] for level in levels],
                             [values[-1] for _, values in curves])
            self.assertEqual(curve["time_s"], curves[0][0])
            order, expected, uncertainty = extrapolated(curve["time_s"], curves)
            self.assertAlmostEqual(limit.get("order") or 0, order or 0, delta=1e-9)
            self.assert_close(curve["curl_m"], expected)
            self.assert_close(curve["uncertainty_m"], uncertainty)

            row = found["judgement"]["limits"][place]
            self.assertEqual(row["limit_m"], curve["curl_m"][-1])
            self.assertEqual(row["limit_error_m"], curve["uncertainty_m"][-1])
            worst = max(range(len(uncertainty)), key=lambda i: uncertainty[i])
            self.assertAlmostEqual(row["largest_error_m"], uncertainty[worst], delta=1e-12)
            self.assertAlmostEqual(row["at_s"], curve["time_s"][worst], delta=1e-9)
        corner = found["limits"][0]
        self.assertGreater(corner["curve"]["uncertainty_m"][-1], 1e-6)  # of a mesh as coarse as this
        self.assertIn("order", corner)
        self.check_results_file(found)
        self.check_report(found)
        self.check_curl(levels[1]["job"], found)

    def check_results_file(self, found):
        for level in found["runs"]:
            path = self.in_folder("results.h5")
            self.run_dccast("fetch", level["job"], "--force", "-o", path)
            with h5py.File(path) as file:
                self.assertEqual(file["monitors/displacement_m"][-1, 0, 1],
                                 level["end_curl_m"][0])
            os.remove(path)

    def check_report(self, found):
        corner = self.limit(found, "corner")
        ends = [1e3 * level["end_curl_m"][0] for level in found["runs"]]
        page = self.dccast("report", found["runs"][0]["job"], "-o", "-")
        limit, half = 1e3 * corner["curl_m"][-1], 1e3 * corner["uncertainty_m"][-1]
        error = abs(ends[0] - limit) + half
        for curl, uncertainty in ((ends[0], error), (limit, half)):
            self.assertIn(f"<strong>{curl:.2f}</strong> mm<em>± {uncertainty:.2f} mm</em>", page)
        self.assertIn("How much of it is discretisation", page)
        self.assertIn(f">{limit:.3f} ± {half:.3f}</td>", page)
        self.assertIn(f">{ends[2]:.3f}</td>", page)
        self.assertEqual(page.count(", limit of finer meshes"), 6)  # three monitors in two charts
        self.assertNotIn("Not known", page)

    def check_curl(self, job_id, found):
        """`dccast curl` has the limit at the job's own steps."""
        curl = json.loads(self.dccast("curl", "--json", job_id))
        corner, limit = curl["monitors"][0], self.limit(found, "corner")
        self.assertEqual(len(corner["limit_m"]), len(curl["time_s"]))
        for name, of_limit in (("limit_m", "curl_m"), ("lower_error_m", "uncertainty_m"),
                               ("upper_error_m", "uncertainty_m")):
            self.assertAlmostEqual(corner[name][-1], limit[of_limit][-1], delta=1e-12)
            self.assertAlmostEqual(corner[name][-2], at(curl["time_s"][-2], limit["time_s"],
                                                        limit[of_limit]), delta=1e-12)

    def test_a_study_whose_client_was_killed_is_taken_up_again(self):
        client, study = self.begin_study(self.case_file())
        until(lambda: len(self.jobs_of(study)) == 3, 20)
        finest = self.jobs_of(study)[0]
        self.client.until_step(finest.id, 1, seconds=60)
        client.kill()
        client.wait()
        self.assertEqual(self.client.job(finest.id).state, job_pb2.RUNNING)

        found, _ = self.study("--study", study)
        self.assertEqual([level["state"] for level in found["runs"]], ["SUCCEEDED"] * 3)
        self.assertIn("order", found["limits"][0])
        again, _ = self.study("--study", study)  # a study that has ended says the same
        self.assertEqual(again, found)

        table = self.dccast("convergence", "--study", study)
        self.assertIn(f"study {study}: ", table)
        self.assertIn(f"{1e3 * self.limit(found, 'corner')['curl_m'][-1]:.3f}", table)

    def test_levels_that_are_missing_are_added_and_no_other(self):
        path = self.case_file()
        client, study = self.begin_study(path)
        until(lambda: self.jobs_of(study), 20)
        client.kill()  # wherever it is in submitting
        client.wait()
        there = {job.id for job in self.jobs_of(study)}
        found, _ = self.study("--study", study, path)
        self.assertEqual([level["refinement"] for level in found["runs"]], [1, 2, 4])
        self.assertLessEqual(there, {level["job"] for level in found["runs"]})
        self.assertEqual(len(self.jobs_of(study)), 3)

        other = self.case_file(((r'^half_width = "0.28 m"', 'half_width = "0.29 m"'),
                                (r'^x = "0.28 m"', 'x = "0.29 m"')))
        said = self.dccast("convergence", "--study", study, other, code=2)
        self.assertIn("another case", said)
        self.assertEqual(len(self.jobs_of(study)), 3)

    def test_a_level_that_is_lost_leaves_what_the_others_say(self):
        path = self.case_file()
        client, study = self.begin_study(path)
        until(lambda: len(self.jobs_of(study)) == 3, 20)
        finest = self.jobs_of(study)[0]
        self.client.until_step(finest.id, 1, seconds=60)
        os.kill(self.daemon.worker_processes()[0], signal.SIGKILL)
        self.assertEqual(client.wait(timeout=60), 3)
        self.assertIn(f"refinement 4 (job {finest.id}) is failed: worker lost",
                      client.stderr.read())

        found, said = self.study("--study", study, "--as-it-is", code=3)
        self.assertIn("signal 9", said)
        self.assertEqual([level["state"] for level in found["runs"]],
                         ["SUCCEEDED", "SUCCEEDED", "FAILED"])
        corner = self.limit(found, "corner")
        curves = [self.curve(level["job"], "corner") for level in found["runs"][:2]]
        self.assertNotIn("order", found["limits"][0])
        self.assertEqual([level["end_curl_m"][0] for level in found["runs"][:2]],
                         [values[-1] for _, values in curves])
        self.assertEqual(corner["curl_m"][-1], curves[1][1][-1])
        largest = max(abs(at(t, *curves[1]) - value) for t, value in zip(*curves[0]))
        self.assertAlmostEqual(corner["uncertainty_m"][-1], 1.25 * largest, delta=1e-12)
        base = found["runs"][0]["job"]
        self.assertIn("Refinement 4 is left out",
                      self.dccast("report", base, "-o", "-"))

        # Deleted, it is no longer a level; submitted again, it is a new one.
        self.run_dccast("delete", finest.id)
        shorter, _ = self.study("--study", study)
        self.assertEqual(len(shorter["runs"]), 2)
        whole, _ = self.study("--study", study, path)
        self.assertEqual([level["state"] for level in whole["runs"]], ["SUCCEEDED"] * 3)
        self.assertEqual(whole["runs"][0]["job"], base)
        self.assertNotEqual(whole["runs"][2]["job"], finest.id)

    def test_a_level_beyond_the_limits_is_refused_before_anything_is_submitted(self):
        # 272 nodes at refinement 2, 990 at 4.
        path = self.case_file(((r"\Z", "\n[limits]\nmaximum_nodes = 500\n"),))
        ended = self.run_dccast("convergence", path, code=2)
        self.assertIn("refinement 4: ", ended.stderr)
        self.assertIn("limits.maximum_nodes = 500", ended.stderr)
        self.assertIn("--levels 2", ended.stderr)
        self.assertEqual(ended.stdout, "")
        listed = self.client.ask("ListJobs")
        self.assertEqual(len(listed.jobs), 0)
        found, _ = self.study("--levels", "2", path)
        self.assertEqual(len(found["runs"]), 2)

    def test_what_cannot_be_studied_is_refused(self):
        unknown = "0f2b9a4e-0000-4000-8000-000000000000"
        self.assertIn("no job belongs to study",
                      self.dccast("convergence", "--study", unknown, code=5))
        self.assertIn("not a study id",
                      self.dccast("convergence", "--study", "mine", code=2))
        self.run_dccast("convergence", code=2)
        path = self.case_file(((r"\n\[\[monitor\]\](?:\n\w.*)*", ""),))
        self.assertIn("[[monitor]]", self.dccast("convergence", path, code=2))

    def test_a_run_that_stands_alone_says_which_command_tells_its_error(self):
        job_id = self.dccast("submit", self.case_file()).strip()
        self.client.until_state(job_id, job_pb2.SUCCEEDED, seconds=60)
        page = self.dccast("report", job_id, "-o", "-")
        self.assertIn("dccast convergence CASE shows it", page)
        self.assertNotIn("limit_m", self.dccast("curl", "--json", job_id))


class Repair(ServiceTest):
    """Levels that are lost, on the fake worker: what is done again, and what is not."""
    settings = {"workers__count": 1, "workers__restarts": 0}
    study = RefinementStudy.study
    case_file, begin_study = RefinementStudy.case_file, RefinementStudy.begin_study
    end, jobs_of = staticmethod(RefinementStudy.end), RefinementStudy.jobs_of

    def titled(self, title):
        return self.case_file(((r"^title = .*$", f'title = "{title}"'),))

    def lose_a_level(self):
        """A study whose finest level was cancelled. Returns its id and that job."""
        client, study = self.begin_study(self.titled("steps=20 sleep_ms=20"))
        until(lambda: len(self.jobs_of(study)) == 3, 20)
        finest = self.jobs_of(study)[0]
        self.client.cancel(finest.id, "in the way")
        self.assertEqual(client.wait(timeout=60), 3)
        return study, finest

    def test_a_cancelled_level_is_done_again(self):
        study, lost = self.lose_a_level()
        self.assertEqual(lost.request_id, f"{study}/4")

        shown, _ = self.study("--study", study, "--as-it-is", code=3)
        self.assertEqual([level["state"] for level in shown["runs"]],
                         ["SUCCEEDED", "SUCCEEDED", "CANCELLED"])

        found, said = self.study("--study", study)
        self.assertEqual([level["state"] for level in found["runs"]], ["SUCCEEDED"] * 3)
        self.assertEqual([level["job"] for level in found["runs"][:2]],
                         [level["job"] for level in shown["runs"][:2]])
        again = self.client.job(found["runs"][2]["job"])
        self.assertEqual(again.request_id, f"{study}/4/2")
        self.assertIn(f"refinement 4: job {again.id} replaces job {lost.id}, which is cancelled",
                      said)

        self.study("--study", study)  # whole now: nothing more is submitted
        self.assertEqual(len(self.jobs_of(study)), 4)

    def test_with_its_file_too_and_only_with_the_same_case(self):
        study, lost = self.lose_a_level()
        other = self.case_file(((r'^half_width = "0.28 m"', 'half_width = "0.29 m"'),
                                (r'^x = "0.28 m"', 'x = "0.29 m"'),
                                (r"^title = .*$", 'title = "steps=20 sleep_ms=20"')))
        self.assertIn("another case",
                      self.dccast("convergence", "--study", study, other, code=2))
        path = self.titled("steps=20 sleep_ms=20")
        for _ in range(2):
            found, _ = self.study("--study", study, path)
            self.assertEqual([level["state"] for level in found["runs"]], ["SUCCEEDED"] * 3)
            self.assertNotEqual(found["runs"][2]["job"], lost.id)
        self.assertEqual(len(self.jobs_of(study)), 4)

    def test_a_level_that_failed_by_its_own_case_is_left_as_it_is(self):
        client, study = self.begin_study(self.titled("steps=20 fail_at=5"))
        self.assertEqual(client.wait(timeout=60), 3)
        found, _ = self.study("--study", study, code=3)
        self.assertEqual([level["state"] for level in found["runs"]], ["FAILED"] * 3)
        self.assertEqual(len(self.jobs_of(study)), 3)


if __name__ == "__main__":
    main()
