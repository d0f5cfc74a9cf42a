#!/usr/bin/python3
"""Entries of tests/record are what they promise, and its scores are those computed by hand."""
import json
import pathlib
import sys
import tempfile
import unittest

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/record"))
import record  # noqa: E402

SCHEMA = jsonschema.Draft7Validator(record.read(record.FOLDER / "entry.schema.json"))


class Entries(unittest.TestCase):
    def test_ten_and_more_fit_the_schema(self):
        self.assertGreaterEqual(len(record.entries()), 10)
        for name, entry in record.entries().items():
            with self.subTest(name):
                self.assertEqual([error.message for error in SCHEMA.iter_errors(entry)], [])

    def test_they_name_their_sources_files_and_what_could_not_be_read(self):
        self.assertEqual(record.check(), [])

    def test_an_entry_without_a_source_or_a_value_is_found(self):
        entry = json.loads(json.dumps(record.entries()["slab-paper-curl"]))
        del entry["not_read"]
        entry["measured"][0]["value"] = None
        entry["cast"][1]["source"] = "hearsay"
        faults = list(record.faults_of("slab-paper-curl", entry))
        self.assertEqual(len(faults), 2)
        self.assertIn("source hearsay is none of its sources", faults[0])
        self.assertIn("not_read must say", faults[1])

    def test_a_datum_with_a_value_needs_a_source(self):
        entry = record.entries()["slab-paper-curl"]
        entry["cast"][0].pop("source")
        self.assertFalse(SCHEMA.is_valid(entry))

    def test_digitised_points_reach_every_radius(self):
        for name in ("billet-al6cu-450", "billet-aa6008-155"):
            entry = record.entries()[name]
            lines = [line for line in (record.FOLDER / entry["points"]).read_text().splitlines() if line[0] != "#"]
            radii = {float(line.split(",")[0]) for line in lines[1:]}
            self.assertEqual({figure["at"]["radius_m"] for figure in entry["measured"]}, radii)


class Scores(unittest.TestCase):
    """Quantiles 10, 15, 20 at 5, 50 and 95 %."""

    quantiles = {0.05: 10.0, 0.5: 15.0, 0.95: 20.0}

    def test_interval_of_a_value(self):
        for value, score in ((12.0, 10.0), (8.0, 10.0 + 20.0 * 2.0), (23.0, 10.0 + 20.0 * 3.0)):
            self.assertAlmostEqual(record.interval_score(record.Measured(value, value), 10.0, 20.0, 0.9), score)

    def test_interval_of_a_band_is_the_mean_over_it(self):
        # Half of 8..12 is below 10, by 1 in the mean.
        self.assertAlmostEqual(record.interval_score(record.Measured(8.0, 12.0), 10.0, 20.0, 0.9), 10.0 + 20.0 * 0.5)
        self.assertAlmostEqual(record.interval_score(record.Measured(22.0, 26.0), 10.0, 20.0, 0.9), 10.0 + 20.0 * 4.0)

    def test_weighted(self):
        measured = record.Measured(23.0, 23.0)
        self.assertAlmostEqual(record.weighted_score(measured, self.quantiles), (0.5 * 8.0 + 0.05 * 70.0) / 1.5)
        # The half between 13 and 17 scores 4 + 4 * 6.
        self.assertAlmostEqual(record.weighted_score(measured, {**self.quantiles, 0.25: 13.0, 0.75: 17.0}),
                               (0.5 * 8.0 + 0.05 * 70.0 + 0.25 * 28.0) / 2.5)

    def test_share_of_a_band_inside(self):
        self.assertEqual(record.Measured(8.0, 12.0).share_inside(10.0, 20.0), 0.5)
        self.assertEqual(record.Measured(20.0, 20.0).share_inside(10.0, 20.0), 1.0)
        self.assertEqual(record.Measured(20.1, 20.1).share_inside(10.0, 20.0), 0.0)

    def test_of_an_entry(self):
        median = {"middle": 5.0, "short-sides": 6.0}  # errors -3 and +4 against 7 to 9 and 2 %
        predicted = {("slab-pull-in-drezet-1995", name): {0.05: value - 2.0, 0.5: value, 0.95: value + 2.0}
                     for name, value in median.items()}
        score, = record.scores(predicted)
        self.assertAlmostEqual(score.rms, 12.5 ** 0.5)
        # 7 to 9 lies 1 above 7 in the mean; 2 lies 2 below 4.
        for computed, by_hand in zip(score.intervals, (4.0 + 20.0, 4.0 + 40.0), strict=True):
            self.assertAlmostEqual(computed, by_hand)
        self.assertEqual(score.shares, [0.0, 0.0])

    def test_what_could_not_be_read_has_no_score(self):
        self.assertEqual(record.scores({("slab-aa5182-711x1680", "deflection-hot"): self.quantiles}), [])

    def test_coverage_is_of_five_unseen_entries_at_least(self):
        def score(name, seen, shares):
            return record.Score({"name": name, "seen": seen}, "mm", [], [], [], shares, [])
        four = [score(f"e{i}", False, [1.0]) for i in range(4)]
        self.assertIn("not stated: 4 entries", record.coverage(four + [score("seen", True, [0.0])]))
        # The fifth holds half of its figures: 4.5 of 5, whatever their number.
        self.assertIn("hold 90 % of 5", record.coverage(four + [score("e5", False, [1.0, 0.0, 1.0, 0.0])]))


class Predictions(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="dccast-record-")
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name) / "mine.json"

    def write(self, quantiles, entry="slab-aa3104-curl", measurement="plant-mean"):
        self.path.write_text(json.dumps({"code": "mine", "version": "1", "predictions": [
            {"entry": entry, "measurement": measurement, "quantiles": quantiles}]}))

    def test_one_that_is_not_sealed_or_changed_since_is_refused(self):
        self.write({"0.05": 31, "0.5": 40, "0.95": 52})
        with self.assertRaisesRegex(record.Fault, "seal a prediction before it is compared"):
            record.sealed(self.path)
        record.seal(self.path)
        self.assertEqual(len(record.sealed(self.path)[0]), 1)
        self.write({"0.05": 35, "0.5": 40, "0.95": 45})
        with self.assertRaisesRegex(record.Fault, "not the file that was sealed"):
            record.sealed(self.path)

    def test_faults_name_what_is_permitted(self):
        for change, message in (({"quantiles": {"0.5": 40}}, "must be 0.05, 0.5 and 0.95"),
                                ({"quantiles": {"0.05": 41, "0.5": 40, "0.95": 45}}, "must not fall"),
                                ({"quantiles": {"0.05": 1, "0.5": 2, "0.95": 3}, "measurement": "corner"},
                                 "no figure corner; it has plant-mean"),
                                ({"quantiles": {"0.05": 1, "0.5": 2, "0.95": 3}, "entry": "mars"}, "mars")):
            with self.subTest(message):
                self.write(**change)
                with self.assertRaisesRegex(record.Fault, message):
                    record.prediction(self.path)


class Page(unittest.TestCase):
    def test_it_is_the_table_of_record_and_prediction(self):
        record.write_page(ROOT / "docs/measured.md", record.FOLDER / "predictions/dccast.json", only_check=True)

    def test_it_leads_with_what_misses(self):
        rows = [line for line in record.page_table(*record.sealed(record.FOLDER / "predictions/dccast.json")).splitlines()
                if line.startswith("| ")][1:]
        missed = ["**missed**" in row for row in rows]
        self.assertEqual(missed, sorted(missed, reverse=True))

    def test_our_prediction_fits_its_schema(self):
        schema = jsonschema.Draft7Validator(record.read(record.FOLDER / "prediction.schema.json"))
        made = record.read(record.FOLDER / "predictions/dccast.json")
        self.assertEqual([error.message for error in schema.iter_errors(made)], [])


if __name__ == "__main__":
    unittest.main()
