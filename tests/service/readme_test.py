#!/usr/bin/python3
"""The case of the page for beginners gives the curl that stands beside it."""
import json
import os
import re
import subprocess

from support import BIN, ServiceTest, main

PAGE = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "first-casting.md")


class Readme(ServiceTest):
    worker = "dccast-worker"

    def test_the_case_in_one_screen_gives_the_curl_beside_it(self):
        with open(PAGE, encoding="utf-8") as file:
            section = file.read().split("## A case in one screen")[1].split("\n## ")[0]
        case = re.search(r"```toml\n(.*?)```", section, re.DOTALL).group(1)
        said = float(re.search(r"^ {4}corner: curl ([\d.]+) mm", section, re.MULTILINE).group(1))
        self.assertLess(case.count("\n"), 60)
        ended = subprocess.run([os.path.join(BIN, "dccast"), "--server", self.daemon.address, "query",
                                "--json", "-"], input=case, capture_output=True, text=True,
                               timeout=120, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        corner, = json.loads(ended.stdout)["monitors"]
        self.assertAlmostEqual(corner["end_curl_m"] * 1e3, said, delta=0.006)


if __name__ == "__main__":
    main()
