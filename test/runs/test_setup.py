# SPDX-License-Identifier: MIT
"""A scan and a change of ID on the simulated wire, with a fault at each step of the change."""
# needs: build/atmega128/firmware/setup.elf
import re
import unittest

from simulator import Run

CHANGED, UNCHANGED, LOST = 1, 2, 4
OK, TIMEOUT = 0, 2

# Packets from the controller: 254 PINGs of the scan, then three of ID 42, one of 100, WRITE, one of 42,
# three of 100. From servos: three in the scan, then of the PING of 100, of the WRITE and of the PING of 42.
SCAN_IN, SCAN_OUT = 254, 3
WRITE_IN, WRITE_OUT = SCAN_IN + 5, SCAN_OUT + 2


class Setup(unittest.TestCase):
    def change(self, *faults):
        """(state, result, IDs found afterwards) of a run that breaks no rule."""
        options = [word for fault in faults for word in ("--fault", fault)]
        run = Run("build/atmega128/firmware/setup.elf", "--host", "stdout", "--seconds", "5", *options,
                  servos="1,100,253")
        self.assertEqual(run.status, 0, run.output)
        self.assertNotIn("faults:  acted 0 times", run.output)
        figures = re.findall(r"^(\w+) (\d+)$", run.output, re.M)
        self.figure = {name: int(number) for name, number in figures}
        then = [int(number) for name, number in figures if name == "then"]
        self.assertEqual([int(number) for name, number in figures if name == "found"], [1, 100, 253])
        return self.figure["state"], self.figure["result"], then

    def test_scan_finds_3_of_254_ids_within_300_ms_and_changes_one(self):
        self.assertEqual(self.change(), (CHANGED, OK, [1, 42, 253]))
        self.assertEqual(self.figure["asked"], 254)
        self.assertLess(self.figure["scan_us"], 300000)
        # seven PINGs, of which six are silent for 0.73 ms each, the write, and one rest of 1.4 ms
        self.assertLess(self.figure["change_us"], 7000)

    def test_any_one_packet_to_the_servo_lost(self):
        for packet in range(SCAN_IN + 1, SCAN_IN + 11):
            expected = (CHANGED, OK, [1, 42, 253])
            if packet == WRITE_IN:
                expected = (UNCHANGED, TIMEOUT, [1, 100, 253])
            for byte in (0, 2, 4):
                self.assertEqual(self.change(f"lose in {packet} {byte}"), expected, packet)

    def test_any_one_reply_lost_or_cut_short_by_a_loss_of_power(self):
        for packet in range(SCAN_OUT + 1, SCAN_OUT + 4):
            for byte in (0, 3, 5):
                self.assertEqual(self.change(f"lose out {packet} {byte}")[::2],
                                 (CHANGED, [1, 42, 253]), packet)
                self.assertEqual(self.change(f"cut out {packet} {byte}")[::2],
                                 (CHANGED, [1, 42, 253]), packet)


if __name__ == "__main__":
    unittest.main()
