#!/usr/bin/python3
"""Comparisons: jobs and answers of queries, judged by the server."""
import json
import os

import grpc

from dccast.v1 import job_pb2, judgement_pb2, service_pb2
from support import ServiceTest, fake_case, main


def question(title, columns):
    """The fake worker's figures of two cases are told apart by a key."""
    case = fake_case(title)
    case.mesh.columns = columns
    return service_pb2.QueryButtCurlRequest(case=case)


def tables(comparison):
    return {part.table.key: part.table for part in comparison.judgement.parts
            if part.HasField("table")}


class Comparisons(ServiceTest):
    def ask(self, title="steps=20", columns=30):
        """The name of the answer."""
        first, *_, last = self.client.stub.QueryButtCurl(question(title, columns), timeout=30)
        self.assertTrue(last.HasField("ended"))
        return first.accepted.answer

    def finished_job(self, title="steps=20", columns=30):
        job = self.client.submit(fake_case(title, mesh={"columns": columns}))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        return job.id

    def compare(self, *runs, **rest):
        return self.client.ask("CompareRuns", runs=[judgement_pb2.ComparedRun(**run) for run in runs],
                               **rest)

    def test_a_job_and_an_answer_are_compared(self):
        comparison = self.compare({"job": self.finished_job()},
                                  {"answer": self.ask(columns=40), "name": "trial"})
        self.assertEqual([run.name for run in comparison.runs],
                         [comparison.runs[0].job[:8], "trial"])
        keys = tables(comparison)["keys"]
        self.assertEqual([cell.text or cell.case_value for cell in keys.rows[0].cells],
                         ["mesh.columns", "30", "40"])
        rows = tables(comparison)["differences"].rows
        self.assertEqual([row.cells[1].value for row in rows], [1.0, 2.0])
        self.assertIn(rows[1].cells[7].code, ("real", "of_unknown_error", "no_difference"))
        self.assertTrue(comparison.judgement.sentences[0].startswith("run 2"))
        self.assertEqual(self.client.steps(comparison.runs[0].job)[-1].monitors[0].displacement_m[1],
                         rows[0].cells[2].value)

    def test_an_answer_of_a_run_that_failed_can_be_compared(self):
        failed = self.ask("steps=20 fail_at=12", columns=31)
        comparison = self.compare({"answer": self.ask(columns=32)}, {"answer": failed})
        self.assertEqual(comparison.runs[1].state, job_pb2.FAILED)
        self.assertEqual(comparison.runs[1].failure.kind, job_pb2.Finding.SOLVE_FAILED)
        self.assertIn("run 2 failed at", comparison.judgement.sentences[0])
        self.assertEqual(len(comparison.judgement.sentences), 2)

    def test_an_answer_from_the_store_names_the_job_that_has_it(self):
        job = self.finished_job(columns=33)
        first, *_ = self.client.stub.QueryButtCurl(question("steps=20", 33), timeout=30)
        self.assertEqual((first.accepted.job, first.accepted.answer), (job, ""))

    def test_a_run_alone_is_judged(self):
        for run in ({"job": self.finished_job()}, {"answer": self.ask(columns=35)}):
            with self.subTest(run=run):
                judged = self.compare(run)
                self.assertEqual(len(judged.runs), 1)
                self.assertIn("corner has", judged.judgement.sentences[0])
                corner = tables(judged)["curls"].rows[0].cells
                self.assertEqual(corner[0].text, "corner")
                charts = [part.chart for part in judged.judgement.parts if part.HasField("chart")]
                self.assertEqual(charts[0].key, "curl")
                self.assertEqual(charts[0].lines[0].y[-1], corner[1].value)

    def test_what_cannot_be_compared_is_refused_with_the_remedy(self):
        job = self.finished_job()
        nothing = "00000000-0000-4000-8000-000000000000"
        for code, runs, word in (
                (grpc.StatusCode.INVALID_ARGUMENT, [], "1 to 100 runs"),
                (grpc.StatusCode.INVALID_ARGUMENT, [{"job": job}, {}], "neither a job nor"),
                (grpc.StatusCode.INVALID_ARGUMENT, [{"job": job}, {"job": "x"}], "UUID"),
                (grpc.StatusCode.NOT_FOUND, [{"job": job}, {"job": nothing}], nothing),
                (grpc.StatusCode.NOT_FOUND, [{"job": job}, {"answer": "x"}], "ask the query again"),
                (grpc.StatusCode.INVALID_ARGUMENT, [{"job": job}, {"job": job, "name": "a\x1bb"}],
                 "name")):
            with self.subTest(word=word):
                error = self.refused(code, self.compare, *runs)
                self.assertIn(word, error.details())
        error = self.refused(grpc.StatusCode.INVALID_ARGUMENT, self.compare, {"job": job},
                             companions=[judgement_pb2.ComparedRun(job=job)])
        self.assertIn("companions give the errors of differences", error.details())

        waiting = self.client.submit(fake_case("steps=20 hang_once_at=1", mesh={"columns": 34}))
        self.refused(grpc.StatusCode.FAILED_PRECONDITION, self.compare, {"job": job},
                     {"job": waiting.id})

    def test_a_file_with_a_long_name_is_compared(self):
        folder = self.in_folder(*(["a-folder-with-a-rather-long-name"] * 8))
        os.makedirs(folder)
        path = os.path.join(folder, "my.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write('title = "steps=20"\n[section]\nhalf_width = "0.25 m"\ninitial_depth = "50 mm"\n'
                       '[time]\nend = "145 s"\n[[monitor]]\nname = "corner"\nx = "0.25 m"\ny = "0 m"\n')
        self.assertIn("run 2: no difference of 0.1 mm or more", self.dccast("compare", path, path))

    def test_the_command_line_prints_the_same(self):
        jobs = [self.finished_job(columns=columns) for columns in (30, 40)]
        printed = self.dccast("compare", *jobs)
        comparison = self.compare(*({"job": job} for job in jobs))
        self.assertIn("MONITOR  RUN  CURL mm", printed)
        for sentence in comparison.judgement.sentences:
            self.assertIn(" ".join(sentence.split()), " ".join(printed.split()))
        of_json = json.loads(self.dccast("compare", "--json", *jobs))
        self.assertEqual(of_json["sentences"], list(comparison.judgement.sentences))
        self.assertEqual([run["job"] for run in of_json["runs"]], jobs)


if __name__ == "__main__":
    main()
