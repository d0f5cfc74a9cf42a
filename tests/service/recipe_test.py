#!/usr/bin/python3
"""The recipe of a start on the real solver: from drafts over candidates to the chosen case, the same again
after the daemon was killed, and cancelled by an interruption."""
import json
import re
import signal
import subprocess

from data_study import DataStudyCase
from dccast.v1 import job_pb2, study_pb2
from support import main
from waiting import until

# Two of the four data are enough.
TWO_DATA = (r'(?s)^"alloy\.specific_heat.*', "")


class Recipe(DataStudyCase):
    def case_file(self):
        return super().case_file(TWO_DATA)

    def design(self, path, *more, code=0, band="0..100 mm", hold="55..90 s"):
        """With so few drafts, recipes of a shorter hold are not known to melt through."""
        return self.dccast("design-recipe", path, "--band", band, "--drafts", "16", "--castings", "3",
                           "--candidates", "2", "--hold", hold, *more, code=code)

    def study(self, study):
        return self.client.ask("GetStudy", id=study)

    def test_from_drafts_to_the_chosen_case(self):
        path = self.case_file()
        chosen, page = (self.in_folder(name) for name in ("chosen.toml", "page.html"))
        screen = self.design(path, "-o", chosen, "--plot", page)
        self.assertRegex(screen, r"Recipe \d: \d+ ± \d+ % of castings end outside 0 to 100 mm")
        self.assertLessEqual(max(len(line) for line in screen.splitlines()), 120)
        with open(page, encoding="utf-8") as file:
            self.assertIn("Recipes of least risk", file.read())

        self.dccast("validate", chosen)
        # The same command finds the study as it is and runs nothing again.
        answer = json.loads(self.design(path, "--json"))
        self.assertIn(answer["study"]["id"], screen)
        self.assertEqual(answer["study"]["runs"], 18 + 6 + 2 + 6)

        found = answer["recipe"]
        best = found["front"][found["chosen"]]
        self.assertEqual(best["castings"], 3)
        self.assertEqual(best["full_dangers"], [])

        with open(chosen, encoding="utf-8") as file:
            text = file.read()
        for change in best["changes"]:
            self.assertIn(change["key"].split(".")[1], text)
        self.assertIn("recipe, 7 numbers", self.dccast("studies"))

    def test_the_steps_of_a_run_follow_its_own_hold(self):
        """Steps are finest after the events of a start, and the error bars are those of such steps."""
        study = self.design(self.case_file(), "--no-wait").strip()
        until(lambda: self.study(study).succeeded >= 8, 120)
        self.client.ask("CancelStudy", id=study)
        jobs = self.client.ask("ListJobs", study=study, states=[job_pb2.SUCCEEDED]).jobs
        begins = {}
        for job in jobs:
            case = self.client.ask("QueryResult", id=job.id).case
            begins[case.schedule.hold_s] = case.time.step_s.at[0]
        self.assertGreater(len(begins), 4)
        for hold_s, begin_s in begins.items():
            self.assertAlmostEqual(begin_s, -hold_s)

    def test_the_daemon_is_killed_and_the_front_is_the_same(self):
        path = self.case_file()
        expected = json.loads(self.design(path, "--json"))["recipe"]
        self.client.ask("DeleteStudy", id=json.loads(self.design(path, "--json"))["study"]["id"])
        study = self.design(path, "--no-wait").strip()
        for ended in (4, 21):  # among the drafts, and among the castings of candidates
            until(lambda: self.study(study).succeeded >= ended, 120)
            self.daemon.kill_with_workers()
            self.daemon.start()
            self.client = self.new_client()
        again = json.loads(self.design(path, "--json"))
        self.assertEqual(again["study"]["id"], study)

        for candidate in expected["front"] + again["recipe"]["front"]:
            del candidate["full_job"]
        self.assertEqual(again["recipe"], expected)

    def test_an_interruption_cancels_and_the_same_command_goes_on(self):
        path = self.case_file()
        running = subprocess.Popen(self.client_command(
            "design-recipe", path, "--band", "0..100 mm", "--drafts", "16", "--castings", "3",
            "--candidates", "2", "--hold", "55..90 s"), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        study = re.search(r"study ([0-9a-f-]{36})", running.stderr.readline())[1]
        until(lambda: self.study(study).succeeded >= 2, 60)
        running.send_signal(signal.SIGINT)
        self.assertIn("is cancelled; repeat the command to resume it", running.communicate(timeout=30)[1])
        self.assertEqual(running.returncode, 130)
        until(lambda: self.study(study).state == study_pb2.STUDY_CANCELLED, 30)
        answer = json.loads(self.design(path, "--json"))
        self.assertEqual(answer["study"]["id"], study)
        self.assertGreaterEqual(answer["recipe"]["chosen"], 0)

    def test_a_run_that_was_cancelled_alone_is_run_again_and_the_plan_grows(self):
        path = self.case_file()
        study = self.design(path, "--no-wait").strip()
        until(lambda: self.study(study).running > 0, 60)
        running = self.client.ask("ListJobs", study=study, states=[job_pb2.RUNNING, job_pb2.QUEUED]).jobs
        self.client.ask("CancelJob", id=running[0].id)
        until(lambda: self.study(study).state == study_pb2.STUDY_CANCELLED, 120)
        self.assertEqual(self.study(study).runs, 18)
        answer = json.loads(self.design(path, "--json"))
        self.assertEqual(answer["study"]["id"], study)
        self.assertEqual(answer["study"]["runs"], 18 + 6 + 2 + 6)

    def test_a_band_that_no_recipe_reaches_is_reported(self):
        error = self.design(self.case_file(), band="300..400 mm", code=3)
        self.assertIn("study", error)

    def test_faults_name_the_limit(self):
        path = self.case_file()
        self.assertIn("--speed 200..300 mm/min: speed_start of the case is",
                      self.design(path, "--speed", "200..300 mm/min", code=2))
        self.assertIn("--band 35 mm: write it as 35..45 mm", self.design(path, band="35 mm", code=2))
        self.assertIn("--hold 10..20: the unit is missing", self.design(path, hold="10..20", code=2))


if __name__ == "__main__":
    main()
