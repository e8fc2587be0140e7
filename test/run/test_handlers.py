"""The handlers of a bus, which are by hand, beside the events of link.h (test/program/handlers.c)."""
import re
import unittest

from simulator import Run


class Handlers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.run_of = Run("build/atmega128/program/handlers.elf", "--seconds", "30", "--host",
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


if __name__ == "__main__":
    unittest.main()
