"""The firmware of every board on its own wiring, and three buses at once."""
import re
import tempfile
import unittest

from simulator import ROOT, Run, controller
from test_manual import manual_packets

CONSOLES = ["cm510", "arbotix"]  # atmega128 and arduino-mega: test_manual.py, test_firmware.py


class Boards(unittest.TestCase):
    def test_all_packets_of_the_manual(self):
        for board in CONSOLES:
            run = controller((ROOT / "examples/manual.script").read_text(), board)
            self.assertEqual(run.status, 0, run.output)
            self.assertEqual([packet[1:] for packet in run.packets], manual_packets(), board)

    def test_a_thousand_pings_break_no_rule(self):
        for board in CONSOLES:
            run = controller("".join(f"ping {1 + n % 3}\n" for n in range(1000)), board, "1-3")
            self.assertEqual(run.status, 0, run.output)
            self.assertIn("rules:   none broken", run.output)
            self.assertEqual(len(run.packets), 2000)

    def test_tied_pins_work_without_return_delay(self):
        script = "".join(f"ping {1 + n % 3}\nread {1 + n % 3} 0 50\n" for n in range(300))
        run = controller("write 254 RETURN_DELAY 0\n" + script, "arbotix", "1-3")
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        self.assertEqual(len(run.packets), 1201)

    def test_the_firmware_of_an_arduino_uno_is_the_readme_program(self):
        run = Run("build/arduino-uno/controller.elf", "--seconds", "2.5", board="arduino-uno",
                  servos="1,2")
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        self.assertEqual([packet for _, _, packet in run.packets],
                         ["FF FF FE 04 03 18 01 E1",
                          "FF FF FE 0E 83 1E 04 01 C8 00 00 02 02 20 03 00 02 5C",
                          "FF FF FE 0E 83 1E 04 01 20 03 00 02 02 C8 00 00 02 5C"])


class SeveralBuses(unittest.TestCase):
    """Two and three buses at once, a servo on each: test/program/three_buses.c."""

    def simulate(self, return_delay, length, buses, *options):
        """What the program says of each bus; delay in register units, READs of so many bytes."""
        with tempfile.NamedTemporaryFile() as eeprom:
            eeprom.write(bytes([return_delay, length, buses]) + b"\xff" * 4093)
            eeprom.flush()
            run = Run("build/arduino-mega/program/three_buses.elf", "--servos", "1:2", "--servos",
                      "2:3", "--eeprom", eeprom.name, "--host", "stdout", "--seconds", "3", *options,
                      board="arduino-mega")
        said = re.split(r"^bus \d$", run.output.split("\ntime:")[0], flags=re.M)[1:]
        self.assertEqual(len(said), buses, run.output)
        run.buses = [{name: int(n) for name, n in re.findall(r"^(\w+) (\d+)$", text, re.M)}
                     for text in said]
        for bus in run.buses:
            self.assert_reconciled(bus)
        return run

    def assert_reconciled(self, bus):
        self.assertEqual(bus["sent"], bus["reads"])
        self.assertEqual(bus["sent"], bus["ok"] + bus["timeouts"] + bus["corrupt"])
        self.assertEqual(bus["ok"], bus["good"] + bus["refused"])
        self.assertEqual(bus["foreign"], 0)

    def assert_well(self, bus):
        self.assertEqual(bus["ok"], bus["sent"])
        for name in ("refused", "timeouts", "corrupt", "refuted", "framing", "overruns", "overflows"):
            self.assertEqual(bus[name], 0, name)

    def assert_undisturbed(self, run, number):
        """Nothing failed, and it counts what its wire saw; a WRITE to all came before."""
        bus = run.buses[number]
        self.assert_well(bus)
        seen = re.findall(rf"^ *\d+ bus{number} (->in|<-out): FF FF (\S\S) [^(]*\(LEN:\d+\)$",
                          run.transcript, re.M)
        self.assertEqual(seen.count(("->in", "FE")), 1)
        sent = [(way, who) for way, who in seen if way == "->in" and who != "FE"]
        replies = [(way, who) for way, who in seen if way == "<-out"]
        self.assertEqual(set(sent + replies), {("->in", f"{number + 1:02}"),
                                               ("<-out", f"{number + 1:02}")})
        self.assertEqual(len(sent), bus["sent"])
        self.assertEqual(len(replies), bus["ok"])

    def test_short_reads_at_the_factory_return_delay_lose_nothing(self):
        for buses in [2, 3]:
            for length in [1, 2, 11]:
                run = self.simulate(1, length, buses)
                self.assertEqual(run.status, 0, run.output)
                for number, bus in enumerate(run.buses):
                    self.assert_undisturbed(run, number)
                    self.assertGreater(bus["ok"], 700)

    def test_long_reads_may_lose_bytes_and_never_unnoticed(self):
        """Three whole tables at once ask for more receive handlers than there are cycles."""
        for delay in [1, 50]:
            self.simulate(delay, 40, 3)

    def test_two_buses_go_on_undisturbed_while_the_third_is_dead(self):
        clean = self.simulate(1, 2, 3)
        for fault in ["1:stuck low", "1:stuck high", "1:brownout 2 5000"]:
            run = self.simulate(1, 2, 3, "--fault", fault)
            self.assertEqual(run.status, 0, run.output)
            for number in (0, 2):
                bus, before = run.buses[number], clean.buses[number]
                self.assert_undisturbed(run, number)
                self.assertGreater(bus["ok"], before["ok"], fault)  # nobody else's work to do
                self.assertLess(bus["longest_us"], before["longest_us"] + 200, fault)
            self.assertEqual(run.buses[1]["ok"], 0, fault)
            self.assertGreater(run.buses[1]["reads"], 100, fault)

    def test_a_bus_that_flips_bits_fails_alone(self):
        # At the factory's return delay the handlers of one bus may hold up the turnaround of another.
        run = self.simulate(25, 2, 3, "--fault", "1:noise 500")
        self.assertEqual(run.status, 0, run.output)
        for number in (0, 2):
            self.assert_well(run.buses[number])
        noisy = run.buses[1]
        self.assertGreater(noisy["timeouts"] + noisy["corrupt"], 50)
        self.assertGreater(noisy["ok"], 200)


if __name__ == "__main__":
    unittest.main()
