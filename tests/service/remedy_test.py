#!/usr/bin/python3
"""What helps against a finding: from the finding of a real run to an amount on screen, in JSON and on the page."""
import json
import os

import dccast
import grpc
from dccast.v1 import study_pb2

from dashboard_test import CASES, InBrowser
from support import ServiceTest, main

CASE = os.path.join(CASES, "start-2d-thickness.toml")
AMOUNT = r"hold \S+ s longer: shell over the block 0\S* -> \S+ mm"
SHORT_HOLD = ("--set", "schedule.hold=30 s")  # the butt bleeds out


class Client:
    def bled_out(self):
        """A job whose butt has bled out."""
        job = self.dccast("submit", *SHORT_HOLD, CASE).strip()
        self.dccast("wait", job, code=3)
        return job


class Remedy(Client, ServiceTest):
    worker = "dccast-worker"

    def test_a_finding_names_no_lever_and_the_command_that_computes_which_and_how_far(self):
        job = self.bled_out()
        shown = self.dccast("show", job)
        self.assertIn("dccast remedy computes what helps.", shown)
        self.assertNotRegex(shown, "(?i)(hold|cast|pour|use) (longer|slower|colder|less)")

        page = self.in_folder("remedy.html")
        screen = self.dccast("remedy", job, "--plot", page)
        # What the drafts refute is named.
        self.assertRegex(" ".join(screen.split()), r"shell_melted_through: of no help: .*?less water")
        self.assertRegex(screen, "shell_melted_through goes: " + AMOUNT)
        with open(page, encoding="utf-8") as file:
            self.assertIn("shell_melted_through goes: hold", file.read())

        # The same command shows the same study again.
        answer = json.loads(self.dccast("remedy", job, "--json"))
        self.assertEqual(len(self.dccast("studies").splitlines()), 2)
        runs = answer["runs"]
        self.assertEqual([run.get("lever_step", {}).get("words") for run in runs[:2]], [None, None])
        self.assertTrue(all(run["lever_step"]["words"] for run in runs[2:]))
        self.assertIn("remedy of job", self.dccast("studies"))

    def test_every_draft_casts_the_same_length(self):
        job = self.dccast("submit", "--set", "schedule.casting_temperature.offset=40 K", CASE).strip()
        self.dccast("wait", job)
        service = dccast.connect(self.daemon.address)
        study = service.remedy(service.job(job)).wait()
        lengths = {}
        for run in study.evaluate().runs:
            lengths[run.lever_step.words] = service.job(run.job).message.last_step.cast_length_m
        self.assertIn("cast 20 % slower", lengths)
        for words, length_m in lengths.items():
            self.assertAlmostEqual(length_m, lengths["pour 10 K colder"], delta=3e-4, msg=words)
        self.assertRegex("\n".join(study.judgement().sentences), "thin_shell (goes|stays): (pour|cast) ")

    def test_what_has_no_remedy_says_why(self):
        sound = self.dccast("submit", "--set", "time.end=20 s", CASE).strip()
        self.dccast("wait", sound)
        self.assertIn("has no finding that a lever of the plant influences",
                      self.dccast("remedy", sound, code=6))
        with self.assertRaises(grpc.RpcError) as refused:
            self.client.ask("CreateStudy",
                            remedy=study_pb2.RemedyPlan(job="00000000-0000-4000-8000-000000000000"))
        self.assertEqual(refused.exception.code(), grpc.StatusCode.NOT_FOUND)


class OnThePage(Client, InBrowser):
    worker = "dccast-worker"

    def test_the_button_of_a_job_leads_to_what_helps(self):
        job = self.bled_out()
        self.go(f"job/{job}")
        self.wait_for("the slab bleeds out", ".findings")
        self.press("Compute what helps", "main")
        self.wait_for("remedy", "[role=status]", 60)
        self.wait_for("answered", "[role=status]", 120)
        self.wait_for("shell_melted_through goes: hold", "#answer", 30)
        self.assertRegex(self.text("#answer"), AMOUNT)
        self.assertEqual(self.complaints(), [])


if __name__ == "__main__":
    main()
