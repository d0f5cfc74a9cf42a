#!/usr/bin/python3
"""A study that designs a mould: it grows run by run, ends flat or says why not, and goes on after
kill -9, a cancellation, the loss of the store."""
import json
import os

import grpc

from dccast.v1 import case_pb2, options_pb2, study_pb2
from support import fake_case, main
from sweep_test import StudyTest
from waiting import stays, until

WANTED = 0.285


def slab_case(title):
    case = fake_case(title)
    case.section.kind = case_pb2.Section.QUARTER_SLAB
    case.section.half_width_m = 0.66
    case.section.half_thickness_m.abscissa = options_pb2.DISTANCE
    case.section.half_thickness_m.at.append(0.0)
    case.section.half_thickness_m.value.append(WANTED)
    case.monitor[0].x_m, case.monitor[0].y_m, case.monitor[0].z_m = 0.66, WANTED, 0.0
    return case


class Mould(StudyTest):
    def design(self, title="steps=3 mould=70", request_id="", **plan):
        plan = {"tolerance_m": 0.5e-3, **plan}
        return self.client.ask("CreateStudy", request_id=request_id, case=slab_case(title),
                               mould=study_pb2.MouldPlan(**plan))

    def opening(self, run):
        curve = self.client.pages(run.job)[0].case.section.half_thickness_m
        return list(zip(curve.at, curve.value))

    def test_it_grows_until_the_slab_is_flat(self):
        study = self.design()
        self.assertEqual((study.runs, study.state), (1, study_pb2.STUDY_RUNNING))

        ended = self.until_ended(study.id)
        self.assertEqual(ended.state, study_pb2.STUDY_SUCCEEDED, ended.message)
        self.assertEqual(ended.runs, ended.succeeded)
        self.assertIn(ended.runs, (2, 3, 4))

        result = self.evaluate(study.id)
        self.assertTrue(result.mould.within_tolerance)
        self.assertLessEqual(result.mould.residual_m, 0.5e-3)
        self.assertTrue(all(abs(half - WANTED) <= 0.5e-3 for half in result.mould.profile_m))
        self.assertEqual(self.opening(result.runs[0]), [(0.0, WANTED)])

        found = list(zip(result.mould.x_m, result.mould.half_opening_m))
        self.assertEqual(found, self.opening(result.runs[-1]))
        self.assertAlmostEqual(found[0][1], WANTED / 0.93, delta=1e-3)
        self.assertAlmostEqual(found[3][1], WANTED / 0.979, delta=1e-3)

        last = self.client.pages(result.runs[-1].job)[0].case
        self.assertEqual(last.monitor[0].y_m, found[3][1])
        self.assertEqual({job.request_id for job in self.jobs_of(study.id)},
                         {f"{study.id}/{run + 1}" for run in range(ended.runs)})

    def test_a_watcher_sees_one_study_to_its_end(self):
        study = self.design("steps=10 sleep_ms=10 mould=70")
        seen = list(self.client.ask("WatchStudy", id=study.id))
        self.assertEqual({message.state for message in seen[:-1]}, {study_pb2.STUDY_RUNNING})
        self.assertEqual(seen[-1].state, study_pb2.STUDY_SUCCEEDED)

    def test_it_ends_with_all_runs_that_are_permitted(self):
        study = self.design(tolerance_m=1e-5, maximum_runs=2)
        ended = self.until_ended(study.id)
        self.assertEqual((ended.state, ended.runs), (study_pb2.STUDY_SUCCEEDED, 2))
        self.assertFalse(self.evaluate(study.id).mould.within_tolerance)

    def test_a_run_that_fails_ends_it_and_says_why(self):
        study = self.design("steps=3 mould=70 fail_open_mm=290")
        ended = self.until_ended(study.id)
        self.assertEqual((ended.state, ended.runs, ended.failed), (study_pb2.STUDY_FAILED, 2, 1))
        self.assertIn("did not converge", ended.message)
        self.assertEqual(self.evaluate(study.id).mould.half_opening_m[0], WANTED)
        self.resume(study.id, failed=True)
        until(lambda: len(self.jobs_of(study.id)) == 3, 20)
        self.assertEqual(self.until_ended(study.id).runs, 2)

    def test_a_run_without_a_steady_part_ends_it_and_says_so(self):
        study = self.design("steps=3")
        ended = self.until_ended(study.id)
        self.assertEqual(ended.state, study_pb2.STUDY_FAILED)
        self.assertIn("cannot be used", ended.message)

    def test_kill_9_in_the_middle(self):
        study = self.design("steps=30 sleep_ms=20 mould=70", "mine")
        until(lambda: self.study(study.id).succeeded == 1 and self.study(study.id).running == 1, 30)
        self.daemon.kill()
        self.restart()
        ended = self.until_ended(study.id)
        self.assertEqual(ended.state, study_pb2.STUDY_SUCCEEDED)
        self.assertTrue(self.evaluate(study.id).mould.within_tolerance)
        self.assertEqual(len(self.jobs_of(study.id)), ended.runs)
        self.assertEqual(self.design("steps=30 sleep_ms=20 mould=70", "mine").id, study.id)
        self.refused(grpc.StatusCode.ALREADY_EXISTS, self.design, "steps=30 sleep_ms=20 mould=70",
                     "mine", tolerance_m=1e-3)

    def test_cancelled_and_resumed(self):
        study = self.design("steps=30 sleep_ms=20 mould=70")
        until(lambda: self.study(study.id).running == 1, 20)
        self.cancel(study.id)
        ended = self.until_ended(study.id)
        self.assertEqual(ended.state, study_pb2.STUDY_CANCELLED)
        stays(lambda: len(self.jobs_of(study.id)) == 1, 0.3)
        self.assertEqual(self.resume(study.id).state, study_pb2.STUDY_RUNNING)
        self.assertEqual(self.until_ended(study.id).state, study_pb2.STUDY_SUCCEEDED)
        self.assertTrue(self.evaluate(study.id).mould.within_tolerance)

    def test_what_is_refused(self):
        for change, field in ((lambda c: c.section.ClearField("kind"), "section.kind"),
                              (lambda c: setattr(c.mesh, "growth", False), "mesh.growth")):
            case = slab_case("steps=2")
            change(case)
            error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.client.ask, "CreateStudy",
                case=case, mould=study_pb2.MouldPlan(tolerance_m=1e-3))
            self.assertIn(field, error.details())
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.design, tolerance_m=0.0)
        self.assertIn("mould.tolerance", error.details())

    def test_the_command(self):
        study = self.design()
        self.until_ended(study.id)
        shown = self.run_dccast("design-mould", "--study", study.id)
        self.assertIn("A mould with half-openings of", shown.stdout)
        self.assertIn("flat within", shown.stdout)

        as_json = json.loads(self.dccast("design-mould", "--study", study.id, "--json"))
        self.assertTrue(as_json["mould"]["within_tolerance"])
        self.assertTrue(as_json["mould"]["is_steady"])
        self.assertEqual(as_json["mould"]["wanted_half_thickness_m"], WANTED)
        residuals = [run["face"]["residual_m"] for run in as_json["runs"]]
        self.assertEqual(min(residuals), residuals[-1])
        self.assertAlmostEqual(residuals[0], 0.07 * WANTED, places=9)

        page = self.in_folder("mould.html")
        self.run_dccast("design-mould", "--study", study.id, "--plot", page, "--no-wait")

        with open(page, encoding="utf-8") as file:
            text = file.read()
        self.assertEqual(text.count("data-kind='chart'"), 2)
        self.assertIn("mould", self.dccast("studies"))
        self.assertIn("mould", self.dccast("studies", "show", study.id))
        self.assertIn("designs no mould", self.dccast(
            "design-mould", "--study",
            self.create(fake_case("steps=1"), {"mesh.rows": [10, 11]}).id, code=2))

    def test_the_store_is_made_again_from_what_is_there(self):
        study = self.design()
        ended = self.until_ended(study.id)
        self.daemon.kill()
        for end in ("", "-wal", "-shm"):
            os.remove(self.in_folder("data", "jobs.sqlite" + end))
        self.restart()
        again = self.until_ended(study.id)
        self.assertEqual((again.state, again.runs), (ended.state, ended.runs))


if __name__ == "__main__":
    main()
