#!/usr/bin/python3
"""Programs are hardened as cmake/dccast_compile_options.cmake asks: hardening_test.py PROGRAM..."""
import re
import subprocess
import sys
import unittest

PROGRAMS = sys.argv[1:]
del sys.argv[1:]


def readelf(option, program):
    return subprocess.run(["readelf", "--wide", option, program], capture_output=True, text=True,
                          check=True, timeout=60).stdout


class Hardening(unittest.TestCase):
    def of_each(self, option, *wanted):
        self.assertTrue(PROGRAMS)
        for program in PROGRAMS:
            with self.subTest(program=program):
                text = readelf(option, program)
                self.assertEqual([p for p in wanted if not re.search(p, text)], [])

    def test_position_independent(self):
        self.of_each("--file-header", r"Type: +DYN")
        self.of_each("--dynamic", r"FLAGS_1.*\bPIE\b")

    def test_relocations_are_read_only_before_main(self):
        self.of_each("--program-headers", r"GNU_RELRO")
        self.of_each("--dynamic", r"FLAGS_1.*\bNOW\b")

    def test_stack_is_not_executable(self):
        self.of_each("--program-headers", r"GNU_STACK.* RW +0x")

    def test_overwritten_stacks_and_buffers_are_detected(self):
        self.of_each("--dyn-syms", r" __stack_chk_fail@", r" __[a-z_]+_chk@")


if __name__ == "__main__":
    unittest.main()
