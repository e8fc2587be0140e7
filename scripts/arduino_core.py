# SPDX-License-Identifier: MIT
"""Builds a sketch as the Arduino IDE does: flags of its platform.txt, core of Debian's arduino-core-avr, library out of
its ZIP.

usage: arduino_core.py SKETCH.ino [--board arduino-mega|arduino-uno]    prints the path of the ELF; docs/arduino.md
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
CORE = pathlib.Path("/usr/share/arduino/hardware/arduino/avr")
LIBRARY = "CDS55xx"
IDE = "10819"

# board of ours -> (chip, ARDUINO_ name, folder of pins_arduino.h), as boards.txt of the core has them
BOARDS = {
    "arduino-mega": ("atmega2560", "AVR_MEGA2560", "mega"),
    "arduino-uno": ("atmega328p", "AVR_UNO", "standard"),
}


def setting(name):
    """A setting of platform.txt, without warning flags."""
    text = (CORE / "platform.txt").read_text()
    value = re.search(rf"^{re.escape(name)}=(.*)$", text, re.M)[1]
    return value.replace("{compiler.warning_flags}", "").split()


class Failed(Exception):
    """A command has failed; the text is its output."""


def run(*command):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise Failed(done.stdout)
    return done.stdout


class Builder:
    """Core and library for `board`, compiled once, below `folder`."""

    def __init__(self, folder, archive, board):
        self.folder = pathlib.Path(folder)
        chip, name, variant = BOARDS[board]
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(self.folder / "libraries")
        self.library = self.folder / "libraries" / LIBRARY
        self.target = [f"-mmcu={chip}", "-DF_CPU=16000000L", f"-DARDUINO={IDE}",
                       f"-DARDUINO_{name}", "-DARDUINO_ARCH_AVR"]
        self.core_includes = [f"-I{CORE / 'cores/arduino'}", f"-I{CORE / 'variants' / variant}"]
        serial = CORE / "libraries/SoftwareSerial/src"
        others = [f"-I{CORE / 'libraries' / name / 'src'}" for name in ("EEPROM", "SPI", "Wire")]
        self.includes = [*self.core_includes, f"-I{self.library / 'src'}", f"-I{serial}", *others]
        # WString.cpp needs DECIMAL_DIG, which float.h of avr-gcc 5 has in C only
        self.core = self.archive("core.a", CORE / "cores/arduino", self.core_includes,
                                 ["-DDECIMAL_DIG=__DECIMAL_DIG__"])
        self.ours = self.archive("cds55xx.a", self.library / "src", self.includes,
                                 ["-Wall", "-Wextra", "-Werror"])
        self.serial = self.archive("serial.a", serial, self.includes, [])

    def compile(self, source, to, includes, warnings=()):
        kind = {".c": "c", ".cpp": "cpp", ".S": "S"}[source.suffix]
        command = "compiler.cpp.cmd" if kind == "cpp" else "compiler.c.cmd"
        run(*setting(command), *setting(f"compiler.{kind}.flags"), *self.target,
            *warnings, *includes, source, "-o", to)
        return to

    def archive(self, name, sources, includes, warnings):
        folder = self.folder / name.replace(".a", "")
        folder.mkdir()
        sources = sorted(path for path in sources.rglob("*") if path.suffix in (".c", ".cpp", ".S"))
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(lambda job: self.compile(job[1], folder / f"{job[0]}.o", includes,
                                                             warnings), enumerate(sources)))
        run(*setting("compiler.ar.cmd"), *setting("compiler.ar.flags"), self.folder / name, *objects)
        return self.folder / name

    def check(self, text):
        """Compiles the C++ `text` and writes nothing."""
        source = self.folder / "check.cpp"
        source.write_text(text)
        run(*setting("compiler.cpp.cmd"), *setting("compiler.cpp.flags"), *self.target, *self.includes,
            "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-MF", self.folder / "check.d", source)

    def linked(self, source, prefix, board):
        """Compiles `source`, a program in C or a sketch, beside the core, and links the library that is installed below
        `prefix`; returns its ELF."""
        folder = self.folder / "linked" / source.stem
        folder.mkdir(parents=True)
        chip = self.target[0].removeprefix("-mmcu=")
        if source.suffix == ".ino":
            (folder / f"{source.stem}.cpp").write_text("#include <Arduino.h>\n" + source.read_text())
            source = folder / f"{source.stem}.cpp"
        ours = [f"-I{prefix}/include/cds55xx", f"-I{prefix}/share/cds55xx/boards/{board}"]
        objects = [self.compile(source, folder / f"{n}.o", includes, ["-Wall", "-Wextra", "-Werror"])
                   for n, includes in enumerate([self.core_includes + ours, ours + self.core_includes])]
        elf = folder / f"{source.stem}.elf"
        run(*setting("compiler.c.elf.cmd"), *setting("compiler.c.elf.flags"), self.target[0], "-o", elf, objects[0],
            f"{prefix}/lib/cds55xx/libcds55xx-{chip}.a", f"{prefix}/lib/cds55xx/constants.ld", self.core, "-lm")
        return elf

    def sketch(self, name, text, *more):
        """Compiles and links the sketch `text` and the sources `more`; returns its ELF."""
        folder = self.folder / name
        folder.mkdir()
        source = folder / f"{name}.ino.cpp"
        source.write_text(f'#include <Arduino.h>\n#line 1 "{name}.ino"\n{text}')
        sources = [source]
        for number, other in enumerate(more):
            sources.append(folder / f"{number}.cpp")
            sources[-1].write_text(other)
        objects = [self.compile(path, path.with_suffix(".o"), self.includes, ["-Wall", "-Wextra"])
                   for path in sources]
        elf = folder / f"{name}.elf"
        run(*setting("compiler.c.elf.cmd"), *setting("compiler.c.elf.flags"), self.target[0], "-o", elf,
            *objects, self.ours, self.serial, self.core, "-lm")
        return elf


def main(arguments):
    parser = argparse.ArgumentParser(description="Builds a sketch for the simulator; prints the path of its ELF.")
    parser.add_argument("sketch", type=pathlib.Path, metavar="SKETCH.ino")
    parser.add_argument("--board", choices=sorted(BOARDS), default="arduino-mega")
    options = parser.parse_args(arguments)
    if not options.sketch.is_file():
        sys.exit(f"arduino_core.py: there is no file {options.sketch}")
    if not CORE.is_dir():
        sys.exit("arduino_core.py: the Arduino core is missing: apt-get install arduino-core-avr")
    try:
        text = options.sketch.read_text()
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f"arduino_core.py: {options.sketch} cannot be read: {error}; name a sketch in UTF-8")
    folder = ROOT / "build/arduino" / options.board
    archive = folder / "library.zip"
    try:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        run(sys.executable, ROOT / "scripts/arduino.py", archive)
        elf = Builder(folder, archive, options.board).sketch(options.sketch.stem, text)
    except Failed as failed:
        sys.exit(f"arduino_core.py: {options.sketch} was not built:\n{failed}")
    except OSError as error:
        sys.exit(f"arduino_core.py: {error.filename or folder}: {error.strerror}; the sketch is built in {folder}: make "
                 "room or set the permissions there")
    print(os.path.relpath(elf))


if __name__ == "__main__":
    main(sys.argv[1:])
