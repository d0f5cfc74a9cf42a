#!/usr/bin/python3
"""What README and the page of commands have a user type exists: commands_test.py FOLDER_OF_PROGRAMS"""
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
PROGRAMS = pathlib.Path(sys.argv.pop(1)) if len(sys.argv) > 1 else ROOT / "build/release/bin"


def help_of(*command):
    return subprocess.run([PROGRAMS / command[0], *command[1:], "--help"], capture_output=True,
                          text=True, timeout=30, check=False)


def readme_commands():
    """Subcommands of dccast in the code of README, of the page of commands and of the quick start."""
    text = "".join((ROOT / page).read_text(encoding="utf-8")
                   for page in ("README.md", "docs/commands.md"))
    quickstart = (ROOT / "deploy/quickstart").read_text(encoding="utf-8")
    typed = re.findall(r"^ {4}dccast ([a-z-]+)", text, re.MULTILINE)
    typed += re.findall(r'\$bin/dccast" ([a-z]+)', quickstart)
    return sorted(set(typed))


class Commands(unittest.TestCase):
    def test_readme_names_the_daily_commands(self):
        self.assertGreaterEqual(len(readme_commands()), 20)

    def test_every_command_explains_itself_with_an_example(self):
        for command in readme_commands():
            with self.subTest(command=command):
                answer = help_of("dccast", command)
                self.assertEqual(answer.returncode, 0, answer.stderr)
                self.assertIn("xample", answer.stdout)

    def test_options_of_the_quick_start_exist(self):
        quickstart = (ROOT / "deploy/quickstart").read_text(encoding="utf-8")
        for command, rest in re.findall(r'\$bin/dccast" ([a-z]+)([^\n|]*)', quickstart):
            for option in re.findall(r"(?<=\s)--?[a-z][\w-]*", rest):
                with self.subTest(command=command, option=option):
                    self.assertRegex(help_of("dccast", command).stdout,
                                     rf"(^|[\s,]){option}\b")

    def test_programs_name_their_version(self):
        for program in ("dccast", "dccastd"):
            with self.subTest(program=program):
                answer = subprocess.run([PROGRAMS / program, "--version"], capture_output=True,
                                        text=True, timeout=30, check=False)
                self.assertEqual(answer.returncode, 0, answer.stderr)
                self.assertRegex(answer.stdout, r"\d+\.\d+\.\d+")

    def test_the_citation_names_the_version_of_the_programs(self):
        cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"),
                          re.MULTILINE).group(1)
        self.assertIn(cited, subprocess.run([PROGRAMS / "dccast", "--version"], capture_output=True,
                                            text=True, timeout=30, check=False).stdout)

    def test_a_wrong_option_is_a_usage_error(self):
        for program in ("dccast", "dccastd"):
            with self.subTest(program=program):
                answer = subprocess.run([PROGRAMS / program, "--no-such-option"],
                                        capture_output=True, text=True, timeout=30, check=False)
                self.assertEqual(answer.returncode, 2)


if __name__ == "__main__":
    unittest.main()
