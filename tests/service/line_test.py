#!/usr/bin/python3
"""Castings that somebody types on a line: added, imported, edited and forgotten, through kills; who may; and what they
say of an uncertainty study."""
import json
import os
import subprocess

import dccast
import grpc
from access_test import AccessTest
from data_study import CASE, DATA, DataStudyCase
from dccast.v1 import judgement_pb2, line_pb2, service_pb2
from state_test import StateTest
from support import BIN, Daemon, ServiceTest, main

Casting = line_pb2.LineCasting


class Records(ServiceTest):
    worker = "dccast-worker"  # no job runs

    def dccast(self, *words, code=0):
        ended = subprocess.run([os.path.join(BIN, "dccast"), "--server", self.daemon.address, "line", *words],
                               capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(ended.returncode, code, ended.stderr)
        return ended.stdout + ended.stderr

    def line(self, name="pit-3"):
        return self.client.ask("GetLine", id=name)

    def test_castings_are_added_shown_edited_and_forgotten(self):
        self.dccast("add", "pit-3", CASE, "--count", "200", "--outcome", "sound")
        self.dccast("add", "pit-3", CASE, "--outcome", "bled-out", "--at", "40 mm")
        self.dccast("add", "pit-3", CASE, "--outcome", "sound", "--curl", "38 41 35 37 mm", "--sawn-off", "60 mm")
        first, second, third = self.line().castings
        self.assertEqual((first.count, first.outcome, first.ended), (200, Casting.SOUND, True))
        self.assertEqual((second.outcome, second.at_m), (Casting.BLED_OUT, 0.04))
        self.assertEqual([round(curl, 4) for curl in third.cold_curl_m], [0.038, 0.041, 0.035, 0.037])
        self.assertEqual(len({first.recipe, second.recipe, third.recipe}), 1)
        self.assertTrue(first.typed_by)
        shown = self.dccast("show", "pit-3")
        for text in ("200 sound", "bled-out at 40 mm", "38.0 41.0 35.0 37.0 mm cold", "60 mm sawn off"):
            self.assertIn(text, shown)
        self.assertIn("202", self.dccast("list"))

        self.dccast("edit", "pit-3", "2", "--outcome", "cracked")
        self.assertEqual(self.line().castings[1].outcome, Casting.CRACKED)
        self.dccast("forget", "pit-3", "1", "3")
        self.assertEqual([casting.id for casting in self.line().castings], ["2"])
        self.assertIn("has no castings 7", self.dccast("forget", "pit-3", "7", code=2))
        self.assertIn("--all", self.dccast("forget", "pit-3", code=2))
        self.assertIn("--all", self.dccast("forget", "pit-3", "2", "--all", code=2))
        self.dccast("restart", "pit-3")
        self.assertFalse(self.line().castings)
        self.dccast("forget", "pit-3", "--all")
        self.refused(grpc.StatusCode.NOT_FOUND, self.line)

    def test_a_table_adds_all_or_none_and_once(self):
        table = os.path.join(self.folder, "castings.csv")

        def write(*lines):
            with open(table, "w", encoding="utf-8") as file:
                file.write("\n".join(("recipe, outcome, count, at, curl", *lines)) + "\n")
        write(f"{CASE}, sound, 200, ,", f"{CASE}, sound, 1, 40 mm,", f"{CASE}, bled-out, 0, 900 m,")
        said = self.dccast("import", "pit-3", table, code=2)
        for text in ("castings.csv:3: at", "castings.csv:4: count", "castings.csv:4: at", "permitted: 0 to 30 m"):
            self.assertIn(text, said)
        self.refused(grpc.StatusCode.NOT_FOUND, self.line)

        write(f"{CASE}, sound, 200, ,", f"{CASE}, bled-out, 1, 40 mm,")
        self.dccast("import", "pit-3", table)
        self.daemon.kill()
        self.restart()
        self.assertIn("had 2 records", self.dccast("import", "pit-3", table))
        self.assertEqual(self.line().number, 201)

    def test_a_request_id_is_for_one_request(self):
        with open(CASE, encoding="utf-8") as file:
            read = self.client.ask("ReadCase", text=file.read())
        request = line_pb2.AddCastingsRequest(id="pit-3", request_id="mine")
        request.recipes.add(case=getattr(read, "case"))
        request.castings.add(record=Casting(outcome=Casting.SOUND, count=1))
        added = self.client.stub.AddCastings(request, timeout=30)
        again = self.client.stub.AddCastings(request, timeout=30)
        self.assertEqual(list(added.castings), list(again.castings))
        self.assertTrue(again.repeated_request)
        request.castings[0].record.count = 2
        self.refused(grpc.StatusCode.ALREADY_EXISTS, self.client.stub.AddCastings, request, timeout=30)

    def test_nothing_acknowledged_is_lost_by_a_kill(self):
        for count in range(1, 6):
            self.dccast("add", "pit-3", CASE, "--count", str(count), "--outcome", "sound")
            self.daemon.kill()
            self.restart()
        self.assertEqual([casting.count for casting in self.line().castings], [1, 2, 3, 4, 5])


    def test_python_adds_edits_and_forgets(self):
        service = dccast.connect(self.daemon.address)
        mine = service.read("start-2d-thickness")
        ids = service.add_castings("pit-3", [
            {"recipe": mine, "outcome": "sound", "count": 200},
            {"recipe": mine, "outcome": "bled-out", "at_m": 0.04}])
        service.edit_casting("pit-3", ids[1], outcome="cracked")
        self.assertEqual([casting.outcome for casting in service.line("pit-3").castings],
                         [Casting.SOUND, Casting.CRACKED])
        service.forget_castings("pit-3", ids[:1])
        self.assertEqual(service.lines()[0].number, 1)
        with self.assertRaises(dccast.DccastError) as caught:
            service.add_castings("pit-3", [{"recipe": mine}, {"recipe": mine, "outcome": "sound", "count": 0}])
        self.assertEqual([fault.field for fault in caught.exception.faults],
                         ["castings[0].outcome", "castings[1].count"])


class Owners(AccessTest):
    def test_a_submitter_edits_and_forgets_on_his_own_line_and_an_admin_on_all(self):
        self.start()
        mine, other, admin = (self.remote(self.token_of(name, role)) for name, role in
                              (("mine", "submitter"), ("other", "submitter"), ("boss", "admin")))
        with open(CASE, encoding="utf-8") as file:
            read = mine.ReadCase(service_pb2.ReadCaseRequest(text=file.read()), timeout=30)
        request = line_pb2.AddCastingsRequest(id="pit-3", request_id="mine")
        request.recipes.add(case=getattr(read, "case"))
        for _ in range(3):
            request.castings.add(record=Casting(outcome=Casting.SOUND, count=1))
        mine.AddCastings(request, timeout=30)
        # Others add to the line, but take nothing off.
        request.request_id = "other"
        other.AddCastings(request, timeout=30)

        edit = line_pb2.EditCastingRequest(id="pit-3", casting="1",
                                           record=Casting(outcome=Casting.CRACKED, count=1))
        forget = line_pb2.ForgetCastingsRequest(id="pit-3", castings=["2"])
        self.refusal(grpc.StatusCode.PERMISSION_DENIED, other.EditCasting, edit)
        self.refusal(grpc.StatusCode.PERMISSION_DENIED, other.ForgetCastings, forget)
        mine.EditCasting(edit, timeout=10)
        mine.ForgetCastings(forget, timeout=10)
        edit.casting, forget.castings[0] = "3", "4"
        admin.EditCasting(edit, timeout=10)
        admin.ForgetCastings(forget, timeout=10)
        line = mine.GetLine(line_pb2.GetLineRequest(id="pit-3"), timeout=10)
        self.assertEqual([(casting.id, casting.outcome) for casting in line.castings],
                         [("1", Casting.CRACKED), ("3", Casting.CRACKED), ("5", Casting.SOUND), ("6", Casting.SOUND)])
        self.assertEqual([casting.typed_by for casting in line.castings], ["mine", "boss", "other", "other"])


class Backup(StateTest):
    def test_lines_are_backed_up_and_restored(self):
        add = [os.path.join(BIN, "dccast"), "--server", self.daemon.address, "line", "add", "pit-3", CASE]
        subprocess.run([*add, "--count", "200", "--outcome", "sound"], check=True, timeout=60)
        backup, restored = (os.path.join(self.folder, name) for name in ("backup", "restored"))
        code, said = self.command("backup", "--to", backup)
        self.assertEqual(code, 0, said)
        subprocess.run([*add, "--outcome", "bled-out"], check=True, timeout=60)
        self.daemon.kill_with_workers()
        code, said = self.command("restore", "--from", backup, data=restored)
        self.assertEqual(code, 0, said)
        self.assertEqual(self.command("check", "--deep", data=restored)[0], 0)

        other = os.path.join(self.folder, "other")
        os.mkdir(other)
        self.daemon = Daemon(other, data_directory=restored).start()
        self.client = self.new_client()
        line = self.client.stub.GetLine(line_pb2.GetLineRequest(id="pit-3"), timeout=30)
        self.assertEqual([(casting.count, casting.outcome) for casting in line.castings], [(200, Casting.SOUND)])


class Experience(DataStudyCase):
    def test_what_was_cast_conditions_an_uncertainty(self):
        path = self.case_file()
        other = os.path.join(self.folder, "other.toml")
        with open(path, encoding="utf-8") as file, open(other, "w", encoding="utf-8") as to:
            to.write(file.read().replace('hold = "60 s"', 'hold = "77 s"', 1)
                     .replace('title = "', 'title = "held long, ', 1))
        self.dccast("line", "add", "pit-3", path, "--count", "200", "--outcome", "sound")
        self.dccast("line", "add", "pit-3", path, "--curl", "0.2 mm")
        self.dccast("line", "add", "pit-3", other, "--outcome", "bled-out")
        only = [word for key in DATA for word in ("--only", key)]
        shown = self.dccast("uncertainty", path, "--runs", "16", "--line", "pit-3", *only)
        self.assertIn("Line pit-3 has 201 castings of this recipe in 2 records, 1 of them with", shown)
        self.assertIn("1 castings of other recipes are not used: held long, ", shown)
        self.assertRegex(shown, r"Of its next castings [\d.]+ % are in danger")

        study = json.loads(self.dccast("studies", "--json"))[0]["id"]
        question = judgement_pb2.JudgeStudyRequest(id=study, line="pit-3", with_result=True)
        experience = self.client.stub.JudgeStudy(question, timeout=60).result.experience
        self.assertLess(experience.after.danger, experience.before.danger)
        self.assertGreaterEqual(experience.after.effective_draws, 30)
        self.assertEqual(experience.castings_of_others, 1)
        self.assertEqual(list(experience.counted), ["1", "2"])
        self.assertEqual(len(experience.told), 4)
        assumed = self.dccast("uncertainty", "--study", study, "--assume-sound")
        self.assertIn("It is assumed that this recipe is cast daily", assumed)
        question.line = "pit-4"
        self.refused(grpc.StatusCode.NOT_FOUND, self.client.stub.JudgeStudy, question, timeout=60)


    def test_what_was_cast_conditions_query_recipe_and_remedy(self):
        path = self.case_file()
        only = [word for key in DATA for word in ("--only", key)]
        self.dccast("line", "add", "pit-3", path, "--count", "200", "--outcome", "sound")
        self.dccast("line", "add", "pit-3", path, "--curl", "0.2 mm")
        shown = self.dccast("query", path, "--line", "pit-3")
        self.assertIn("Nothing is said of line pit-3: no study has drafts over the data of this recipe;", shown)
        design = ("design-recipe", path, "--band", "0..100 mm", "--drafts", "16", "--castings", "3",
                  "--candidates", "2", "--hold", "55..90 s", "--line", "pit-3")
        self.assertIn("line pit-3 conditions nothing: no study has drafts", self.dccast(*design, code=6))

        self.dccast("uncertainty", path, "--runs", "16", *only)
        self.assertRegex(self.dccast(*design, code=6), "study .* has no range .*; dccast uncertainty CASE computes")
        self.dccast("uncertainty", path, "--runs", "64")
        said = "Line pit-3 has 201 castings of this recipe in 2 records"
        self.assertIn(said, self.dccast("query", path, "--line", "pit-3"))
        answer = json.loads(self.dccast("query", path, "--line", "pit-3", "--json"))
        self.assertIn(said, " ".join(answer["judgement"]["sentences"]))

        shown = self.dccast(*design)
        self.assertIn(said, shown)
        self.assertIn("have data that what was cast leaves possible", " ".join(shown.split()))
        studies = json.loads(self.dccast("studies", "--json"))
        plan = next(study["recipe"] for study in studies if "recipe" in study)
        self.assertEqual(plan["experience"]["records"], 2)
        self.assertFalse(plan["members"], "no list needs them")
        # The same castings find the same study; one more casting begins another.
        self.dccast(*design)
        self.assertEqual(len(json.loads(self.dccast("studies", "--json"))), len(studies))
        self.dccast("line", "add", "pit-3", path, "--outcome", "sound")
        self.dccast(*design, "--no-wait")
        self.assertEqual(len(json.loads(self.dccast("studies", "--json"))), len(studies) + 1)

        band = ("--set", "plausibility.least_curl=20 mm", "--set", "plausibility.greatest_curl=30 mm")
        job = self.dccast("submit", *band, path).strip()
        self.dccast("wait", job)
        shown = " ".join(self.dccast("remedy", job, "--line", "pit-3").split())
        self.assertIn("All drafts have the data of the casting in the middle of those", shown)
        self.assertIn("Line pit-3 has 202 castings of this recipe in 3 records", shown)


if __name__ == "__main__":
    main()
