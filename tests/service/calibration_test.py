#!/usr/bin/python3
"""Calibration on the real solver: hidden values found again from the curl and a temperature that they give,
on screen, as JSON, as a page and as a case that is valid; bad measurements; a daemon and a client that are
killed."""
import json
import random
import re
import signal
import subprocess
import unittest

from data_study import DataStudyCase
from support import SANITIZED, main
from waiting import until

FREE = ("--free", "schedule.casting_temperature=± 10 K",
        "--free", "cooling.bottom_block.contact_coefficient=0.6..1.6 times")
HIDDEN = ("--set", "schedule.casting_temperature=684 degC",
          "--set", "cooling.bottom_block.contact_coefficient.scale=1.3")


class Calibration(DataStudyCase):
    def measured(self, path, *more, name="curl.csv", every=1):
        """The casting with hidden values as a file of measurements, with noise of 5 um and 1 K."""
        answer = json.loads(self.dccast("query", path, "--set", "quality=draft", *HIDDEN, "--json"))
        noise = random.Random(1)
        corner = answer["monitors"][0]
        lines = ["time [s], curl corner [mm]"]
        for time_s, curl_m in list(zip(answer["time_s"], corner["curl_m"]))[::every]:
            if curl_m is not None:
                lines.append(f"{time_s}, {1e3 * curl_m + noise.gauss(0.0, 5e-3)}")
        return self.write_file(name, "\n".join([*more, *lines]) + "\n")

    @unittest.skipIf(SANITIZED, "the client waits 60 s for an answer, and this daemon takes longer")
    def test_hidden_values_are_found_again(self):
        path = self.case_file()
        measured = self.measured(path)
        page, output = (self.in_folder(name) for name in ("page.html", "calibrated.toml"))
        answer = json.loads(self.dccast("calibrate", path, "--measured", measured, *FREE, "--runs", "16",
                                        "--json", "--plot", page, "-o", output))
        keys = answer["calibration"]["keys"]

        for key, hidden in zip(keys, (0.7, 0.7)):  # places of 684 in 670 to 690, of 1.3 in 0.6 to 1.6
            self.assertLess(key["low"], hidden)
            self.assertGreater(key["high"], hidden)
        self.assertLess(min(key["narrowed"] for key in keys), 0.8)

        curve = answer["calibration"]["curves"][0]
        self.assertLess(curve["off_after"], curve["off_before"])
        self.assertIn("check_error", curve)  # true runs have checked it
        self.assertGreater(answer["calibration"]["runs"][0], 16)
        # Asked for by its id alone, the server finds the further runs too.
        judged = self.client.ask("JudgeStudy", id=answer["study"]["id"]).judgement
        self.assertEqual(answer["judgement"]["sentences"], list(judged.sentences))
        self.assertEqual(keys[0]["key"], "schedule.casting_temperature.offset")
        self.assertEqual(keys[0]["unit"], "K")
        with open(page, encoding="utf-8") as file:
            self.assertIn("data after, 5 to 95 %", file.read())

        with open(output, encoding="utf-8") as file:
            text = file.read()
        self.assertIn(f"# calibrated from {measured}", text)
        self.assertIn('"cooling.bottom_block.contact_coefficient" = ', text)

        self.dccast("validate", output)
        # The written case reproduces the measurement better than the original one.
        ends = [json.loads(self.dccast("query", case, "--set", "quality=draft", "--json"))
                ["monitors"][0]["end_curl_m"] for case in (path, output)]
        self.assertLess(abs(ends[1] - curve["measured"]["curl_m"][-1]),
                        abs(ends[0] - curve["measured"]["curl_m"][-1]) + 2e-5)

        # Taken up again it is the same, on screen too, and makes no further runs.
        study = answer["study"]["id"]
        before = len(json.loads(self.dccast("studies", "--json")))
        again = json.loads(self.dccast("calibrate", "--study", study, "--json"))
        self.assertEqual(again["calibration"], answer["calibration"])
        self.assertEqual(len(json.loads(self.dccast("studies", "--json"))), before)

        screen = self.dccast("calibrate", "--study", study, "--no-wait")
        self.assertIn("free key", screen)
        self.assertLessEqual(max(len(line) for line in screen.splitlines()), 120)
        self.assertIn("calibration, 2 keys", self.dccast("studies"))

    @unittest.skipIf(SANITIZED, "the client waits 60 s for an answer, and this daemon takes longer")
    def test_two_castings_have_one_answer(self):
        path = self.case_file()
        measured = self.measured(path)
        answer = json.loads(self.dccast("calibrate", path, "--measured", measured, "--casting",
                                        f"{path}:{measured}", *FREE, "--runs", "8", "--json"))
        self.assertEqual([curve["casting"] for curve in answer["calibration"]["curves"]], [0, 1])
        self.assertEqual(len(answer["calibration"]["runs"]), 2)

    def test_bad_measurements_name_file_line_and_column(self):
        path = self.case_file()
        measured = self.in_folder("bad.csv")
        for text, fault in (("time [s], curl corner [mm]\n1, 2\n2, three\n", "bad.csv:3:2: \"three\" is no number"),
                           ("time, curl corner [mm]\n", "bad.csv:1:1: \"time\" has no unit"),
                           ("time [s], edge [mm]\n", "is no monitor of the case; permitted: corner")):
            with open(measured, "w", encoding="utf-8") as file:
                file.write(text)
            self.assertIn(fault, self.dccast("calibrate", path, "--measured", measured, *FREE, code=2))
        error = self.dccast("calibrate", path, "--measured", self.measured(path), "--free",
                            "schedule.casting_temperature=warm", code=2)
        self.assertIn("is no range; permitted", error)
        self.assertEqual(json.loads(self.dccast("studies", "--json")), [])  # nothing was queued

    @unittest.skipIf(SANITIZED, "the client waits 60 s for an answer, and this daemon takes longer")
    def test_daemon_and_client_are_killed(self):
        path = self.case_file()
        measured = self.measured(path)
        words = ("calibrate", path, "--measured", measured, *FREE, "--runs", "12")
        study = self.dccast(*words, "--no-wait").strip()
        client = subprocess.Popen(self.client_command("calibrate", "--study", study),
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        until(lambda: "of 12 runs" in client.stderr.readline(), 30)
        client.send_signal(signal.SIGKILL)
        client.wait()
        client.stderr.close()
        self.daemon.kill()
        self.daemon.start()
        answer = json.loads(self.dccast("calibrate", "--study", study, "--json"))

        self.assertGreater(answer["calibration"]["runs"][0], 12)
        self.assertTrue(re.search("[0-9]", answer["calibration"]["keys"][0]["best_text"]))


if __name__ == "__main__":
    main()
