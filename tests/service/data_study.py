"""What the tests of studies of data share: a small case with ranges, and the command line client."""
import os
import re

from support import ServiceTest

CASE = os.path.join(os.path.dirname(__file__), "..", "..", "cases", "start-2d-thickness.toml")

# The shipped thickness section on few cells and for a short time, with four data that have a range.
COARSE = ((r"(?s)^\[mesh\].*?(?=^\[)",
           '[mesh]\ncolumns = 8\nrows = 6\nside_cell = "12 mm"\nbottom_cell = "12 mm"\ngrowth_cell = "12 mm"\n\n'),
          (r'^end = "145 s"$', 'end = "12 s"'),
          (r"(?s)^\[uncertainty\].*", '[uncertainty]\n"schedule.casting_temperature" = "± 10 K"\n'
           '"cooling.bottom_block.temperature" = "50..110 degC"\n'
           '"alloy.specific_heat" = "+- 5 %"\n"alloy.melt_conductivity_factor[1]" = "1..5"\n'))
DATA = ("schedule.casting_temperature", "cooling.bottom_block.temperature", "alloy.specific_heat",
        "alloy.melt_conductivity_factor[1]")


class DataStudyCase(ServiceTest):
    worker = "dccast-worker"
    settings = {"workers__count": 2}

    def case_file(self, *more):
        with open(CASE, encoding="utf-8") as shipped:
            text = shipped.read()
        for pattern, other in COARSE + more:
            text, changes = re.subn(pattern, other, text, flags=re.M)
            self.assertGreater(changes, 0, pattern)
        return self.write_file("case.toml", text)

