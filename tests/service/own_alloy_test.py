#!/usr/bin/python3
"""A card of one's own, named by its path: from the command line, Python, and in a study."""
import pathlib

import dccast
from support import ServiceTest, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
CARD = (ROOT / "cases/alloys/paper.toml").read_text(encoding="utf-8")


class CardTest(ServiceTest):
    def setUp(self):
        super().setUp()
        case = (ROOT / "cases/start-2d-thickness.toml").read_text(encoding="utf-8")
        self.assertIn('card = "paper"', case)
        folder = pathlib.Path(self.folder)
        (folder / "case.toml").write_text(case.replace('card = "paper"', 'card = "./cards/mine.toml"'))
        (folder / "cards").mkdir()
        self.card = folder / "cards/mine.toml"
        self.card.write_text(CARD)
        self.case = str(folder / "case.toml")
        self.service = dccast.connect(self.daemon.address)

    def dccast(self, *words, code=0):
        ended = self.run_dccast(*words, code=code)
        return ended.stdout + ended.stderr


class OwnAlloy(CardTest):
    def test_the_command_line_takes_it_with_the_case(self):
        job = self.service.job(self.dccast("submit", self.case).strip())
        job.wait()
        self.assertEqual(job.case.alloy.card, "mine.toml")
        self.assertEqual(job.case.alloy.liquidus_c, 649)
        self.dccast("query", self.case, "--set", "alloy.card=cards/mine.toml")

    def test_python_takes_it_with_the_case(self):
        job = self.service.submit(self.case).wait()
        self.assertEqual(job.case.alloy.card, "mine.toml")
        self.assertEqual(job.case.alloy.liquidus_c, 649)

    def test_the_runs_of_a_study_have_it(self):
        self.dccast("sweep", self.case, "--grid", "schedule.hold=60 s,90 s")
        for job in self.service.jobs():
            self.assertEqual(job.case.alloy.card, "mine.toml")

    def test_a_table_of_data_becomes_a_card(self):
        table = pathlib.Path(self.folder) / "jmatpro.csv"
        table.write_text("Temperature (C), Liquid (%), Density (g/cm3), Thermal conductivity (W/(m K)), Poisson's ratio\n"
                         "700, 100, 2.34, 95,\n660, 100, 2.36, 92,\n640, 60, 2.45, 120, 0.4\n"
                         "560, 0, 2.55, 180, 0.37\n20, 0, 2.68, 160, 0.33\n")
        self.card.write_text(self.dccast("alloys", "paper", "--table", str(table)))
        self.dccast("validate", self.case)
        alloy = self.service.submit(self.case).cancel().case.alloy
        self.assertEqual((alloy.solidus_c, alloy.liquidus_c), (560, 660))
        self.assertEqual(list(alloy.liquid_fraction.value), [0, 0.6, 1])
        self.assertEqual(list(alloy.density_kg_per_m3.at), [20, 560, 640, 660, 700])
        self.assertAlmostEqual(alloy.density_kg_per_m3.value[0], 2680)
        self.assertEqual(list(alloy.conductivity_w_per_m_k.value), [160, 180, 120, 92, 95])
        self.assertEqual(len(alloy.poisson_ratio.value), 3)

        for text, fault in (("Time [s], density [kg/m3]\n", ":1: \"Time [s]\" is no temperature"),
                            ("T (C), densty (kg/m3)\n20, 2700\n", "unknown key"),
                            ("T (C), density (W)\n20, 2700\n", "is of another kind than kg/m3"),
                            ("T (C), density (kg/m3)\n20, 2,7\n", ":2:"),
                            ("T (C), density (kg/m3)\n20, 2700\nwarm, 2690\n", ':3: "warm"')):
            table.write_text(text)
            self.assertIn(fault, self.dccast("alloys", "paper", "--table", str(table), code=2))

    def test_faults_of_the_card_are_named_with_their_line(self):
        self.card.write_text(CARD + "no_such_key = 3\n")
        said = self.dccast("validate", self.case, code=2)
        self.assertRegex(said, r"in alloy card mine\.toml:\d+:\d+: .*no_such_key")

    def test_a_card_that_is_not_there_is_named(self):
        self.card.unlink()
        self.assertIn("no such file", self.dccast("validate", self.case, code=2))

    def test_keys_of_the_case_go_before_those_of_the_card(self):
        job = self.service.job(self.dccast("submit", self.case, "--set",
                                           "alloy.coherency_solid_fraction=0.8").strip())
        job.wait()
        self.assertEqual(job.case.alloy.coherency_solid_fraction, 0.8)
        self.assertEqual(job.case.alloy.liquidus_c, 649)


class Gaps(CardTest):
    worker = "dccast-worker"  # its check is the real one

    def test_a_gap_of_the_card_is_named_and_ends_no_worker(self):
        for key, word in (("specific_heat = ", "alloy.specific_heat"), ("latent_heat = ", "alloy.latent_heat"),
                          ("exponent = ", "alloy.norton_hoff.exponent")):
            lines = [line for line in CARD.splitlines() if not line.startswith(key)]
            self.card.write_text("\n".join(lines), encoding="utf-8")
            said = self.dccast("validate", self.case, code=2)
            self.assertIn(word, said)
            self.assertIn("is missing", said)
        self.card.write_text(CARD, encoding="utf-8")
        said = self.dccast("validate", self.case, "--set", "alloy.density=2650 kg/m3", code=2)
        self.assertIn("would contract nothing", said)


if __name__ == "__main__":
    main()
