# SPDX-License-Identifier: MIT
"""What `make feedback` measures, on the boards that keep the limit."""
# needs: $(CONSOLE_ELFS)
import unittest

import boards
from feedback import BULKS, LIMIT_US, Feedback


class WholeRobot(unittest.TestCase):
    def test_bulk_read_equals_18_round_trips_and_is_faster(self):
        for board in boards.HOSTED:
            with self.subTest(board):
                run = Feedback(board)
                self.assertEqual(run.status, 0, run.output)
                self.assertEqual(run.bulks, [run.trips] * BULKS)
                self.assertEqual([run.trips[at + 2] for at in range(0, len(run.trips), 14)],
                                 list(range(1, 19)))
                self.assertLess(run.bulk_us, LIMIT_US)
                self.assertGreater(run.trips_us, 18000)


if __name__ == "__main__":
    unittest.main()
