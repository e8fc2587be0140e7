# SPDX-License-Identifier: MIT
"""The commands that set up a servo, with packets and replies lost: what may be sent again is, and nothing else."""
# needs: build/atmega128/full.elf
import pathlib
import re
import tempfile
import unittest

from simulator import Run

# Packets of `id 1 5`: three PINGs of 5, one of 1, WRITE, then three PINGs of 5 and one of 1 if it was lost.
# Packets of `factory 2`: the same with ID 1, which must be free, and RESET.
WRITE, TRY = 5, 9
FLIP = "flip in {} 2 3"  # the servo finds a wrong checksum


class Retries(unittest.TestCase):
    def typed(self, line, *faults, servos="1"):
        """(the reply, the WRITEs and RESETs on the wire)"""
        options = [word for fault in faults for word in ("--fault", fault)]
        with tempfile.TemporaryDirectory() as folder:
            file, transcript = pathlib.Path(folder, "pc"), pathlib.Path(folder, "transcript")
            file.write_text(f"wait 100000\ntext mode program\nwait 50000\nrest\ntext {line}\nwait 400000\nrest\n")
            run = Run("build/atmega128/full.elf", "--host", file, "--transcript", transcript, *options,
                      board="atmega128", servos=servos)
            self.sent = sent = re.findall(r"->in: ((?:[0-9A-F]{2} )+)", transcript.read_text())
        self.assertEqual(run.status, 0, run.output)
        self.assertNotIn("faults:  acted 0 times", run.output)
        heard = [bytes.fromhex("".join(line.split()[4:])).decode()
                 for line in run.output.splitlines() if line.startswith("heard")]
        return heard[-1].replace("\r\n", "\n"), [packet for packet in sent if packet.split()[4] in ("03", "06")]

    def lost(self, count):
        return [FLIP.format(WRITE + TRY * n) for n in range(count)]

    def test_id_whose_write_was_lost_is_written_again(self):
        for count in (0, 1, 2):
            said, written = self.typed("id 1 5", *self.lost(count))
            self.assertEqual((said, len(written)), ("ID 5 at 1000000bps\nok\n", 1 + count))

    def test_id_whose_write_is_always_lost_ends_after_three_tries(self):
        said, written = self.typed("id 1 5", *self.lost(3))
        self.assertRegex(said, r"\Aunchanged: ID 1 at 1000000bps\nerror 2: ")
        self.assertEqual(len(written), 3)

    def test_id_whose_reply_was_lost_is_not_written_again(self):
        # replies: of the PING of 1, and of the WRITE
        for fault in ("lose out 2 3", "cut out 2 4", "flip out 2 5 3"):
            said, written = self.typed("id 1 5", fault)
            self.assertEqual((said, len(written)), ("ID 5 at 1000000bps\nok\n", 1), fault)

    def test_write_that_the_servo_found_damaged_is_sent_again(self):
        for line, flip, reply in (("id 1 5", "flip in 5 5 3", "ID 5 at 1000000bps\nok\n"),
                                  ("baud 1 500000", "flip in 5 5 3", "ID 1 at 500000bps\nok\n"),
                                  ("set 1 MIN_VOLTAGE 6.5V", "flip in 3 5 3", "written\nok\n")):
            said, written = self.typed(line, flip)
            self.assertEqual((said, len(written)), (reply, 2), line)

    def test_baud_whose_write_was_lost_is_written_again(self):
        said, written = self.typed("baud 1 500000", *self.lost(1))
        self.assertEqual((said, len(written)), ("ID 1 at 500000bps\nok\n", 2))

    def test_factory_whose_reset_was_lost_is_sent_again(self):
        said, written = self.typed("factory 2", *self.lost(1), servos="2")
        self.assertEqual((said, len(written)), ("ID 1 at 1000000bps\nok\n", 2))

    def test_factory_of_id_1_whose_reset_was_lost_is_sent_again(self):
        # PING, RESET, PINGs: the place stays the same
        said, written = self.typed("factory 1", FLIP.format(2))
        self.assertEqual((said, len(written)), ("ID 1 at 1000000bps\nok\n", 2))

    def test_set_and_restore_send_each_lost_packet_again(self):
        # READ of both limits, READ, WRITE, READ, and the like of restore: the packet or its reply is lost
        for line, write, reply in (("set 1 MIN_VOLTAGE 6.5V", 3, "written\nok\n"),
                                   ("restore 1 MIN_VOLTAGE 6.5V", 3, "MIN_VOLTAGE = 6V (60) differed: written\nok\n")):
            for way in ("in", "out"):
                for number in range(1, write + 2):
                    said, written = self.typed(line, f"flip {way} {number} 2 3")
                    writes = 2 if (way, number) == ("in", write) else 1  # a WRITE whose reply was lost is not repeated
                    self.assertEqual((said, len(written)), (reply, writes), (line, way, number))

    def test_restore_tells_not_written_from_not_confirmed(self):
        """READ of restore, then READ, WRITE, READ of each of three tries."""
        lost = "differs: not written\nerror 2: ", [f"flip in {n} 2 3" for n in (3, 6, 9)]
        no_reply = "differed: sent, not confirmed\nerror 3: ", [f"flip out {n} 2 3" for n in range(3, 13)]
        no_read_back = "differed: sent, not confirmed\nerror 3: ", [f"flip out {n} 2 3" for n in range(4, 13)]
        for says, faults in (lost, no_reply, no_read_back):
            said, _ = self.typed("restore 1 MIN_VOLTAGE 6.5V", *faults)
            self.assertRegex(said, rf"\AMIN_VOLTAGE = 6V \(60\) {says}")

    def test_set_of_an_absent_servo_ends_after_three_tries(self):
        for line in ("set 9 MIN_VOLTAGE 6.5V", "restore 9 MIN_VOLTAGE 6.5V"):
            said, written = self.typed(line)
            self.assertRegex(said, r"\Aerror 2: servo 9: ")
            self.assertEqual(written, [])
            self.assertEqual(len(self.sent), 3)

    def test_lock_whose_reply_was_lost_is_not_sent_again(self):
        said, written = self.typed("lock 1", "lose out 2 2")
        self.assertEqual((said, len(written)), ("written\nok\n", 1))


if __name__ == "__main__":
    unittest.main()
