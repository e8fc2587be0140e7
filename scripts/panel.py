#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the control panel: the simulator with the firmware, behind a WebSocket that also serves the page.

The page may connect only if it was loaded from this server (websockify's ExpectOrigin), so no other
page that is open in the browser can drive the robot. Ctrl-C ends all of it.
"""
import argparse
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "build/panel"
SIMULATOR = ROOT / "build/host/cds55xx-sim"
PORT_LINE = re.compile(r"127\.0\.0\.1:(\d+)")


def fail(text):
    print(f"panel: {text}", file=sys.stderr)
    sys.exit(1)


def check_port(text):
    """The port of the page. It must be free: websockify itself would only print a traceback."""
    if not re.fullmatch("[0-9]{1,5}", text) or not 1 <= int(text) <= 65535:
        fail(f"no port '{text}': give a number of 1 to 65535, as in make panel PANEL_PORT=8056")
    port = int(text)
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError as error:
            fail(f"port {port}: {error.strerror}; end the other program, or choose a port: make panel PANEL_PORT=8056")
    return port


def start_simulator(options):
    """Returns the process and the port of the firmware's host UART.

    `--rules warn`: the simulator reports a broken rule and goes on. `diagnose` causes collisions on purpose."""
    command = [SIMULATOR, "firmware", options.elf, "--board", options.board, "--servos", options.servos,
               "--host", "tcp:0", "--eeprom", options.eeprom, "--rules", "warn", *options.more]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, bufsize=1)
    for line in process.stdout:
        match = PORT_LINE.search(line)
        if match:
            return process, int(match[1])
    fail(f"the simulator ended with status {process.wait()}")


def start_server(options, target):
    origins = " ".join(f"http://{host}:{options.port}" for host in ("127.0.0.1", "localhost"))
    command = ["websockify", "--web", str(PAGE), "--auth-plugin", "ExpectOrigin", "--auth-source", origins,
               f"127.0.0.1:{options.port}", f"127.0.0.1:{target}"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def wait_for_server(server, port):
    while server.poll() is None:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1).close()
            return
        except OSError:
            continue
    fail(f"websockify ended with status {server.returncode}")


def end(process):
    """Kills what a SIGTERM does not end: websockify may ignore the first one, and ignores each later one."""
    process.terminate()
    try:
        process.wait(2)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def parse(arguments):
    """Options after `--` go to the simulator. They are split off first, because argparse would read the ELF file as one of them."""
    split = arguments.index("--") if "--" in arguments else len(arguments)
    parser = argparse.ArgumentParser(description=__doc__, usage="%(prog)s ELF --board BOARD --eeprom FILE "
                                     "[--servos IDS] [--port N] [-- OPTION_OF_THE_SIMULATOR...]")
    parser.add_argument("elf")
    parser.add_argument("--board", required=True)
    parser.add_argument("--servos", default="1-18")
    parser.add_argument("--eeprom", required=True)
    parser.add_argument("--port", default="8055", help="of the page")
    options = parser.parse_args(arguments[:split])
    options.more = arguments[split + 1:]
    return options


def main():
    options = parse(sys.argv[1:])

    if not shutil.which("websockify"):
        fail("websockify is missing: make deps-panel installs it")
    options.port = check_port(options.port)
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:  # as by nohup
            signal.signal(number, signal.default_int_handler)
    simulator, target = start_simulator(options)
    server = start_server(options, target)
    try:
        wait_for_server(server, options.port)
        print(f"control panel: http://127.0.0.1:{options.port}/?connect", flush=True)
        print("Open this address in a browser. Ctrl-C ends the simulation.", flush=True)
        for line in simulator.stdout:
            if not line.startswith("connect with"):
                print(line, end="", flush=True)
    except KeyboardInterrupt:
        pass
    finally:
        end(simulator)
        end(server)
    return simulator.returncode if simulator.returncode > 0 else 0


if __name__ == "__main__":
    sys.exit(main())
