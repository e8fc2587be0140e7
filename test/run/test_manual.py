"""The manual's own packets, on the wire, byte for byte and in order."""
import unittest

from simulator import ROOT, controller


def manual_packets():
    lines = (ROOT / "test/manual_packets.tsv").read_text().splitlines()
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    return [("->in" if sender == "controller" else "<-out", bytes_) for _, sender, bytes_ in rows]


class Manual(unittest.TestCase):
    def all_packets_on(self, board):
        run = controller((ROOT / "examples/manual.script").read_text(), board)
        self.assertEqual(run.status, 0, run.output)
        self.assertEqual([packet[1:] for packet in run.packets], manual_packets())

    def test_there_are_41_packets(self):
        self.assertEqual(len(manual_packets()), 41)

    def test_all_packets_on_atmega128(self):
        self.all_packets_on("atmega128")

    def test_all_packets_on_arduino_mega(self):
        self.all_packets_on("arduino-mega")


if __name__ == "__main__":
    unittest.main()
