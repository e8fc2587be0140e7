"""The cycle with 50 servos at 250 Hz: test/program/cycle50.c."""
import re
import unittest

from simulator import Run

PERIOD = 4000 * 16  # cycles


class Cycle(unittest.TestCase):
    def test_50_servos_at_250_hz(self):
        run = Run("build/atmega128/program/cycle50.elf", "--host", "stdout", "--seconds", "20",
                  servos="1-50")
        figure = {name: int(number) for name, number in
                  re.findall(r"^(\w+) (\d+)$", run.output, re.M)}
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        for name in ("missed", "refused", "failed", "timeouts", "corrupt", "refuted", "foreign",
                     "framing_errors", "overruns", "ring_overflows"):
            self.assertEqual(figure[name], 0, name)
        self.assertEqual(figure["periods"], 1250)
        self.assertEqual(figure["sent"], figure["ok"])
        self.assertEqual(figure["sent"], 1 + figure["periods"] + figure["reads"])
        self.assertGreaterEqual(figure["reads"], 3 * 1249)  # 3 in each period
        self.assertLess(figure["oldest_us"], 17.5 * 4000)  # 50 servos, 3 in a period
        self.assertGreater(figure["utilisation_permille"], 800)

        goals = [(cycle, bytes.fromhex(packet)) for cycle, way, packet in run.packets
                 if way == "->in" and packet.startswith("FF FF FE FE 83")]
        self.assertEqual(len(goals), 1250)
        phases = [cycle - number * PERIOD for number, (cycle, _) in enumerate(goals)]
        # a turn of the main loop, one that sets 50 goals excepted: that is when the first go out
        self.assertLess(max(phases[1:]) - min(phases[1:]), 100 * 16)
        for number, (_, packet) in enumerate(goals):
            positions = [packet[8 + 5 * i] | packet[9 + 5 * i] << 8 for i in range(50)]
            waves = [(4 * number + 20 * i) % 1024 for i in range(50)]  # all of one commit
            self.assertEqual(positions, [256 + (1023 - w if w & 512 else w) for w in waves])


if __name__ == "__main__":
    unittest.main()
