#!/usr/bin/python3
"""What a user begins on the pages, in a real Chromium: a recipe search and what it found, the design of a mould, a
calibration, castings of a line, a job that waits, and a casting that is followed."""
import os

from selenium.webdriver.common.by import By

from dashboard_test import InBrowser
from data_study import DATA, DataStudyCase
from dccast.v1 import job_pb2, study_pb2
from line_test import Casting
from mould_test import slab_case
from recipe_test import TWO_DATA
from support import main
from waiting import until
from wall_test import Wall


class Begun(InBrowser):
    def open_case(self, path):
        """Uploads a case on the page of new ones."""
        self.go("new")
        self.find("#found svg.casting", 40)
        self.find("#new-file").send_keys(path)
        self.wait_for(self.title_of(path), "#found")

    @staticmethod
    def title_of(_):
        return "of one processor"

    def fill(self, **entries):
        for key, value in entries.items():
            box = self.find(f"#study-{key}")
            if box.get_attribute("type") != "file":
                box.clear()
            box.send_keys(value)

    def begin(self, kind, **entries):
        """Begins a study of the case that is shown. @return its id"""
        self.press("Study of it", "#found")
        self.wait_for("page: ", "#study-case")
        self.find("#kind").send_keys(kind)
        self.fill(**entries)
        self.press("Begin")
        return self.id_in_address("study")

    def id_in_address(self, page):
        self.wait_up_to(60).until(lambda browser: f"#/{page}/" in browser.current_url)
        return self.browser.current_url.split("/")[-1]

    def study(self, study):
        return self.client.ask("GetStudy", id=study)

    def cancel_study(self, study):
        self.client.ask("CancelStudy", id=study)

    def case_of(self, job):
        return self.client.ask("QueryResult", id=job).case


class Recipes(DataStudyCase, Begun):
    def test_a_recipe_is_searched_and_taken(self):
        self.open_case(self.case_file(TWO_DATA))
        study = self.begin("recipe", band="0..100 mm", hold="55..90 s", drafts="16", castings="3", candidates="2")
        plan = self.study(study).recipe
        self.assertEqual((plan.drafts, plan.castings, plan.candidates), (16, 3, 2))
        self.assertEqual(plan.greatest_curl_m, 0.1)
        until(lambda: self.study(study).state == study_pb2.STUDY_SUCCEEDED, 280)
        self.wait_for("answered", "main p[role=status]")

        found = self.client.ask("EvaluateStudy", id=study).recipe
        self.wait_for(f"Recipe {found.chosen + 1}: ", "#answer")
        self.press(f"Take recipe {found.chosen + 1}, the chosen one")
        self.press("Queue as a job", "#found")
        self.wait_for("Queued as", "#found", seconds=60)
        taken = self.case_of(self.text("#found p[role=status] a"))
        full = self.case_of(found.front[found.chosen].full_job)
        self.assertEqual(taken.schedule, full.schedule)
        self.assertNotEqual(taken.schedule.hold_s, 0.0)
        self.assertEqual(self.complaints(), [])

    def test_a_limit_that_cannot_be_is_named(self):
        self.open_case(self.case_file())
        self.press("Study of it", "#found")
        self.wait_for("page: ", "#study-case")
        self.find("#kind").send_keys("recipe")
        self.fill(band="35 mm")
        self.press("Begin")
        self.wait_for("35 mm: write it as 35..45 mm", "main .bad")
        self.fill(band="35..45 mm", speed="200..300 mm/min")
        self.press("Begin")
        self.wait_for("speed_start of the case is", "main .bad")


class Calibrations(DataStudyCase, Begun):
    def test_one_is_begun_with_a_file_of_measurements(self):
        measured, wrong = (os.path.join(self.folder, name) for name in ("curl.csv", "wrong.csv"))
        lines = [f"{t}, {0.1 * t}" for t in range(2, 12)]
        for path, heads in ((measured, "time [s], curl corner [mm]"), (wrong, "time [s], curl nowhere [mm]")):
            with open(path, "w", encoding="utf-8") as file:
                file.write("\n".join([heads, *lines]) + "\n")
        self.open_case(self.case_file())
        self.press("Study of it", "#found")
        self.wait_for("page: ", "#study-case")
        self.find("#kind").send_keys("calibration")
        self.press("Begin")
        self.wait_for("Choose the file", "main .bad")
        self.fill(measured=wrong, runs="24")
        self.press("Begin")
        self.wait_for("wrong.csv:1", "main .bad")
        self.fill(measured=measured)
        self.press("Begin")
        study = self.id_in_address("study")
        sweep = self.study(study).sweep
        self.assertEqual((sweep.purpose, sweep.runs), (study_pb2.SweepPlan.CALIBRATION, 24))
        self.assertIn("cooling.bottom_block.temperature", [axis.key for axis in sweep.axes])
        self.assertEqual(sweep.measured[0].monitor, "corner")
        self.assertAlmostEqual(sweep.measured[0].curl_m[-1], 1.1e-3)
        self.wait_for("data after", "#answer", seconds=120)


class Moulds(Begun):
    def test_one_is_designed_of_a_former_job(self):
        job = self.client.submit(slab_case("steps=3 mould=70")).id
        self.client.until_state(job, job_pb2.SUCCEEDED)
        self.go(f"job/{job}")
        self.press("New case from it")
        study = self.begin("mould design", tolerance="1", most="6")
        plan = self.study(study).mould
        self.assertEqual((plan.tolerance_m, plan.maximum_runs), (1e-3, 6))
        until(lambda: self.study(study).state == study_pb2.STUDY_SUCCEEDED, 60)
        self.wait_for("mould design", "main p[role=status]")
        self.wait_for("answered", "main p[role=status]")


class Lines(DataStudyCase, Begun):
    def castings(self):
        return self.client.ask("GetLine", id="pit-3").castings

    def type_casting(self, **words):
        for key, text in words.items():
            box = self.find(f"#casting-{key.replace('_', '-')}")
            box.clear()
            box.send_keys(text)
        self.press("Keep it")

    def test_castings_are_typed_corrected_forgotten_and_marked(self):
        path = self.case_file()
        only = [word for key in DATA[:2] for word in ("--only", key)]
        study = self.dccast("uncertainty", path, "--runs", "16", "--no-wait", *only).strip()
        until(lambda: self.study(study).state == study_pb2.STUDY_SUCCEEDED, 120)
        with open(path, encoding="utf-8") as file:
            case = self.client.ask("ReadCase", text=file.read()).case
        recipe = self.client.submit(case).id

        self.go("lines")
        self.wait_for("No lines yet.")
        self.find("main summary").click()
        self.wait_for(recipe[:8], "#casting-recipe")
        self.find("#line-name").send_keys("pit-3")
        self.find(f"#casting-recipe option[value='job {recipe}']").click()
        self.type_casting(count="no")
        self.wait_for("number", "main .bad")
        self.type_casting(count="200")
        self.wait_for("200 sound", "main table")
        record, = self.castings()
        self.assertEqual((record.count, record.outcome), (200, Casting.SOUND))

        self.find("main summary").click()
        self.find("#casting-outcome option[value=BLED_OUT]").click()
        self.find("#casting-recipe option[value='start-3d']").click()
        self.type_casting(at="40")
        self.wait_for("bled out at 40 mm", "main table")
        self.assertAlmostEqual(self.castings()[1].at_m, 0.04)
        self.assertNotEqual(self.castings()[1].recipe, record.recipe)

        self.press("Correct", "main table tr:last-child")
        self.find("#casting-outcome option[value=CRACKED]").click()
        self.type_casting(curl="38 41 35 37")
        self.wait_for("38 41 35 37 mm cold", "main table")
        self.assertEqual(self.castings()[1].outcome, Casting.CRACKED)

        # The answer of a study given these castings, and which of them it rests on.
        self.go(f"study/{study}")
        self.wait_for("line pit-3", "#line")
        self.find("#line option[value='pit-3']").click()
        self.wait_for("200", "#answer", seconds=60)
        self.find("a[href^='#/line/pit-3/']").click()
        self.wait_for("counts", "main tbody tr:first-child")
        self.wait_for("does not count", "main tbody tr:last-child")

        self.press("Forget", "main table tr:last-child")
        self.press("Forget it", "dialog")
        until(lambda: len(self.castings()) == 1, 10)
        self.press("Begin afresh")
        self.press("Begin afresh", "dialog")
        self.wait_for("No castings.")
        self.assertEqual(self.complaints(), [])


class Waiting(DataStudyCase, Begun):
    def test_a_job_waits_for_another(self):
        path = self.case_file()
        with open(path, encoding="utf-8") as file:
            case = self.client.ask("ReadCase", text=file.read()).case
        first = self.client.submit(case).id
        self.client.ask("PauseJob", id=first)
        self.open_case(path)
        self.wait_for(first[:8], "#after")
        self.find(f"#after option[value='{first}']").click()
        self.find("#after-end option[value=AWAITED_ANY_END]").click()
        self.press("Queue as a job", "#found")
        self.wait_for("Queued as", "#found", seconds=60)
        job = self.client.job(self.text("#found p[role=status] a"))
        self.assertEqual((list(job.after), job.after_end), ([first], job_pb2.AWAITED_ANY_END))
        self.client.cancel(first)
        self.client.until_state(job.id, job_pb2.SUCCEEDED, seconds=60)
        self.assertEqual(self.complaints(), [])


class Following(Wall, Begun):
    def test_one_is_prepared_and_watched(self):
        self.open_case(self.case_file(20))
        self.press("Prepare to follow it", "#found")
        self.wait_for("ensemble", "#found p[role=status]", seconds=60)
        self.wait_for("dccast follow", "#found p[role=status]")
        for study in self.studies():
            self.cancel_study(study.id)

        job = self.follow_on_line()
        self.measure(job, 30)
        self.go(f"job/{job}")
        self.find("a[href^='#/casting/']").click()
        self.wait_for("corner now", ".figure")
        self.wait_for("pit-3", "h1")
        self.client.cancel(job)


if __name__ == "__main__":
    main()
