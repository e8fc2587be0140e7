# SPDX-License-Identifier: MIT
"""The handlers of a bus, which are by hand, beside the events of link.h (test/firmware/library/handlers.c)."""
# needs: build/atmega128/firmware/handlers.elf $(patsubst %,build/%/firmware/foreign_handler.elf,atmega128 arbotix)
import re
import sys
import unittest

from simulator import ROOT, Run

sys.path.insert(0, str(ROOT / "scripts"))
import measure


class Handlers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.run_of = Run("build/atmega128/firmware/handlers.elf", "--seconds", "30", "--host",
                         "stdout")
        cls.said = {name: int(number) for name, number in
                    re.findall(r"^(\w+) (\d+)$", cls.run_of.output, re.M)}

    def test_they_do_what_the_events_say(self):
        self.assertIn("ended by the firmware", self.run_of.output)
        self.assertEqual(self.said["differed"], 0)

    def test_they_leave_registers_and_flags_as_they_were(self):
        self.assertEqual(self.said["spoilt"], 0)

    def test_their_longest_path(self):
        """All paths, which the bench can but try to reach."""
        for name, most in (("rx", 50), ("udre", 50), ("tx", 30), ("tied_rx", 80)):
            self.assertGreater(self.said[name], 20)
            self.assertLessEqual(self.said[name], most, name)


class ForeignHandlers(unittest.TestCase):
    """A handler of the program's own that holds interrupts off, at all phases of READs of 50 bytes:
    with two enables, and with tied pins, whose receive handler is longer."""

    def held_off(self, board, cycles):
        run = measure.Run("firmware/foreign_handler", "--seconds", "5", "--rules", "warn", board=board,
                          eeprom=[(cycles - 24) // 3], good=False)
        self.assertEqual(run.off, cycles)
        return run

    def test_foreign_handler_of_285_cycles_loses_nothing(self):
        for board in ("atmega128", "arbotix"):
            run = self.held_off(board, 285)
            self.assertEqual(run.figure["good"], run.figure["reads"], run.output)
            self.assertEqual(run.figure["overruns"], 0)
            self.assertIn("rules:   none broken", run.output)

    def test_foreign_handler_of_321_cycles_loses_bytes(self):
        for board in ("atmega128", "arbotix"):
            run = self.held_off(board, 321)
            self.assertGreater(run.figure["overruns"], 100)
            self.assertLess(run.figure["good"], run.figure["reads"])


if __name__ == "__main__":
    unittest.main()
