#!/usr/bin/python3
"""Uncertainty and sensitivity of a case on the real solver: from its ranges to screen, JSON and page, with
a run that fails counted, and taken up again after the client has gone."""
import json
import os
import re

import grpc

from data_study import CASE, DATA, DataStudyCase
from dccast.v1 import study_pb2
from support import main
from waiting import until

CARDS = os.path.join(os.path.dirname(CASE), "alloys")


class DataStudy(DataStudyCase):
    def only(self):
        return [word for key in DATA for word in ("--only", key)]

    def test_uncertainty_from_case_to_page(self):
        path = self.case_file()
        page = self.in_folder("page.html")
        screen = self.dccast("uncertainty", path, *self.only(), "--runs", "12", "--plot", page,
                             "--band", "0..100 mm")
        self.assertIn("12 runs: 12 valid", screen)
        self.assertIn("curl of the corner", screen)
        self.assertRegex(screen, r"\n\d+ % of castings end inside the accepted band")
        self.assertRegex(screen, r"Measure \S+ first")
        self.assertLessEqual(max(len(line) for line in screen.splitlines()), 100)
        with open(page, encoding="utf-8") as file:
            self.assertIn("data, 5 to 95 %", file.read())

        study = re.search(r"study ([0-9a-f-]{36})", screen)[1]
        answer = json.loads(self.dccast("uncertainty", "--study", study, "--json"))
        spread = answer["spread"]
        self.assertEqual(spread["runs"], 12)
        self.assertGreater(spread["inside_band"], 0.5)  # its lower edge is near the curls
        for low, middle, high in zip(spread["low_m"], spread["median_m"], spread["high_m"]):
            self.assertLessEqual(low, middle)
            self.assertLessEqual(middle, high)

        ends = [run["end_curl_m"][0] for run in answer["runs"]]
        self.assertLess(spread["low_m"][-1], max(ends))
        self.assertGreater(spread["high_m"][-1], min(ends))
        self.assertEqual(len(spread["shares"]), len(DATA) + 1)  # and what the surface does not follow

        shares = [share["total"][-1] for share in spread["shares"]]
        self.assertGreater(sum(shares), 0.9)
        self.assertIn("uncertainty, 4 data", self.dccast("studies"))

        again = json.loads(self.dccast("uncertainty", "--study", study, "--json"))
        self.assertEqual(again["spread"], spread)

    def test_the_data_of_every_shipped_alloy_can_be_drawn(self):
        for card in sorted(os.listdir(CARDS)):
            alloy = card.removesuffix(".toml")
            words = ("uncertainty", CASE, "--set", f"alloy.card={alloy}", "--runs", "64", "--no-wait")
            with self.subTest(alloy):
                # For heat alone: the density of one rises as it melts, the other has no mush.
                refused = {"al6cu": "would contract nothing", "pure_aluminium": "has no mush"}.get(alloy)
                if refused:
                    self.assertIn(refused, self.dccast(*words, code=2))
                    continue
                study = self.dccast(*words).strip()
                self.client.ask("CancelStudy", id=study)

    def test_a_run_that_fails_is_counted(self):
        # The shell over a cold block turns by more than this, that over a hot one by less.
        path = self.case_file((r'^"cooling.bottom_block.temperature" = .*$',
                               '"cooling.bottom_block.temperature" = "50..990 degC"'),
                              (r"^\[uncertainty\]$",
                               '[validity]\nmaximum_rotation = "0.2 degrees"\n\n[uncertainty]'))
        answer = json.loads(self.dccast("uncertainty", path, *self.only(), "--runs", "12", "--json"))
        failed = [run for run in answer["runs"] if run["state"] != "SUCCEEDED" or run["beyond_validity"]]
        self.assertTrue(failed)
        screen = self.dccast("uncertainty", "--study", answer["study"]["id"])
        self.assertIn(f"{12 - len(failed)} valid", screen)

    def test_sensitivity_from_case_to_page(self):
        path = self.case_file()
        answer = json.loads(self.dccast("sensitivity", path, *self.only(), "--json"))
        effects = answer["judgement"]["effects"]
        self.assertEqual(len(effects), len(DATA))
        by_key = {effect["key"]: effect for effect in effects}
        hot = by_key["cooling.bottom_block.temperature"]
        self.assertNotEqual(hot["low_m"], hot["high_m"])

        page = self.in_folder("page.html")
        screen = self.dccast("sensitivity", "--study", answer["study"]["id"], "--plot", page)
        self.assertIn("9 runs: 9 valid", screen)
        self.assertIn("error of a difference has not been measured", screen)  # of a mesh of its own
        with open(page, encoding="utf-8") as file:
            self.assertIn("Change of the curl of the corner", file.read())
        # Runs that change one key each permit no interpolation.
        with self.assertRaises(grpc.RpcError) as refused:
            self.client.ask("PredictStudy", id=answer["study"]["id"])
        self.assertIn("one key at a time", refused.exception.details())

    def test_runs_that_give_no_answer_are_refused_at_once(self):
        said = self.dccast("uncertainty", CASE, "--runs", "8", code=2)
        for word in ("are too few to tell 28 keys apart", "31 or more", "make 31 runs"):
            self.assertIn(word, said)
        self.assertFalse(self.client.ask("ListStudies").studies)

    def test_a_study_without_an_answer_is_no_success(self):
        for words in (("uncertainty", "--runs", "31"), ("sensitivity",)):
            study = self.dccast(words[0], CASE, *words[1:], "--no-wait").strip()
            self.dccast(words[0], "--study", study, "--no-wait")  # under way
            self.client.ask("CancelStudy", id=study)
            until(lambda: self.client.ask("GetStudy", id=study).state
                  == study_pb2.STUDY_CANCELLED, 30)
            self.dccast(words[0], "--study", study, code=3)

    def test_levers_are_moved_too(self):
        path = self.case_file()
        study = self.dccast("sensitivity", path, "--no-wait").strip()
        axes = {axis.key for axis in self.client.ask("GetStudy", id=study).sweep.axes}
        for key in ("schedule.casting_speed.scale", "schedule.casting_speed.shift",
                    "schedule.water_flow.scale", "schedule.hold.scale",
                    "cooling.water.wetting.lag", "schedule.casting_temperature.offset"):
            self.assertIn(key, axes)
        self.client.ask("CancelStudy", id=study)
        until(lambda: self.client.ask("GetStudy", id=study).state
              == study_pb2.STUDY_CANCELLED, 30)

    def test_faults_of_ranges_name_their_line(self):
        path = self.case_file((r'^"alloy.specific_heat" = .*$', '"alloy.specific_heet" = "± 5 %"'))
        self.assertIn("uncertainty.alloy.specific_heet", self.dccast("uncertainty", path, code=2))
        error = self.dccast("uncertainty", self.case_file(), "--only", "time.end", code=2)
        self.assertRegex(error, r"time\.end.*has no range; permitted: those with one: ")

    def test_a_study_goes_on_when_its_daemon_is_killed(self):
        path = self.case_file()
        study = self.dccast("uncertainty", path, *self.only(), "--runs", "12", "--no-wait").strip()
        self.daemon.kill()
        self.daemon.start()
        answer = json.loads(self.dccast("uncertainty", "--study", study, "--json"))
        self.assertEqual(answer["spread"]["runs"], 12)


if __name__ == "__main__":
    main()
