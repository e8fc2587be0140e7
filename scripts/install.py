#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Installs library, simulator and documents below a prefix, and removes them again.

usage: install.py check|install|uninstall --prefix DIR [--destdir DIR]
                  [--mcus "MCU ..."] [--cflags "..."] [--ldflags "..."]

check: fails with one line on stderr if this user may not write there, before make builds anything.
install: writes share/cds55xx/manifest, too: the files, and the folders that did not exist before. The libraries of other chips
stay as they are, not rebuilt, if they were installed with the same headers; else they are removed.
uninstall: removes what the manifest names, and nothing else.
"""
import argparse
import contextlib
import getpass
import os
import pathlib
import re
import shlex
import shutil
import sys

from version import version

ROOT = pathlib.Path(__file__).resolve().parents[1]
MANIFEST = "share/cds55xx/manifest"
NEW = ".cds55xx-new" # ends the name of a file until it replaces the installed one


def user():
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return f"user {os.getuid()}"


def refuse(text):
    sys.exit(f"install.py: {text}")


def check(prefix):
    """Ends the program unless the nearest folder that exists takes new files."""
    folder = prefix
    while not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    if not folder.exists():
        refuse(f"{folder} is a link to {os.readlink(folder)}, which does not exist; remove it, or name another PREFIX")
    if not folder.is_dir():
        refuse(f"{folder} is no folder; name another one: make install PREFIX=$HOME/.local")
    if os.statvfs(folder).f_flag & os.ST_RDONLY:
        refuse(f"{folder} is on a read-only file system; make install PREFIX=$HOME/.local")
    if not os.access(folder, os.W_OK | os.X_OK):
        refuse(f"{folder} may not be written by {user()}; make install PREFIX=$HOME/.local, or use sudo")


def filled(name, words):
    """A template of packaging/ with its @WORDS@."""
    text = (ROOT / "packaging" / name).read_text()
    return re.sub(r"@([A-Z_]+)@", lambda match: words[match[1]], text)


def library(mcu):
    return f"lib/cds55xx/libcds55xx-{mcu}.a"


def headers():
    """Yields (installed path, source) of each header. They have a folder of their own: pkg-config must never name /usr/include,
    which has the headers of the host."""
    for header in sorted((ROOT / "include").rglob("*.h")):
        yield f"include/cds55xx/{header.relative_to(ROOT / 'include')}", header


def contents(options, kept):
    """(path below the prefix, source file or text) of all that is written. The libraries of the chips `kept` stay as they are."""
    mcus = sorted({*options.mcus, *kept})
    words = {"VERSION": version(), "CFLAGS_LIST": ";".join(options.cflags.split()),
             "LDFLAGS_LIST": ";".join(options.ldflags.split()), "MCUS": " ".join(mcus)}
    yield "bin/cds55xx-sim", ROOT / "build/host/cds55xx-sim"
    yield "bin/cds55xx-send-lines", ROOT / "scripts/send-lines.py"
    yield "share/man/man1/cds55xx-sim.1", ROOT / "packaging/cds55xx-sim.1"
    yield from headers()
    for mcu in options.mcus:
        yield library(mcu), ROOT / f"build/lib/libcds55xx-{mcu}.a"
    for mcu in mcus:
        yield f"lib/pkgconfig/cds55xx-{mcu}.pc", filled("cds55xx.pc.in", {
            **words, "MCU": mcu, "CFLAGS": f"-mmcu={mcu} {options.cflags}",
            "LDFLAGS": f"-mmcu={mcu} {options.ldflags}"})
    yield "lib/cds55xx/constants.ld", ROOT / "mk/constants.ld"
    for name in ["cds55xx-config.cmake", "cds55xx-config-version.cmake"]:
        yield f"lib/cmake/cds55xx/{name}", filled(f"{name}.in", words)
    yield "lib/cmake/cds55xx/avr-gcc.cmake", ROOT / "packaging/avr-gcc.cmake"
    for board in sorted((ROOT / "boards").glob("*/board.*")):
        yield f"share/cds55xx/{board.relative_to(ROOT)}", board
    yield "share/cds55xx/scripts/plot.gp", ROOT / "scripts/plot.gp"
    for file in sorted((ROOT / "examples").rglob("*")):
        if file.is_file() and file.suffix != ".elf" and "build" not in file.relative_to(ROOT).parts:
            yield f"share/cds55xx/{file.relative_to(ROOT)}", file
    yield "share/doc/cds55xx/LICENSE", ROOT / "LICENSE"
    yield "share/doc/cds55xx/README.md", ROOT / "README.md"


def is_whole(prefix, kind, name):
    """True if install can have written this row. A damaged row may name anything."""
    parts = pathlib.PurePath(name).parts
    if not name or not name.isprintable() or os.path.isabs(name):
        return False
    if kind == "folder":
        return True
    return kind == "file" and ".." not in parts and ((prefix / name).is_symlink() or not (prefix / name).is_dir())


def read_manifest(prefix):
    """([(kind, name) of each whole line], the number of the first line that is not whole, or 0)"""
    *lines, rest = (prefix / MANIFEST).read_text(errors="surrogateescape").split("\n")
    rows = [tuple(line.partition(" ")[::2]) for line in lines]
    damaged = [number for number, row in enumerate(rows, 1) if not is_whole(prefix, *row)]
    if rest or not lines: # the last line has its end, too
        damaged.append(len(lines) + 1)
    return [row for row in rows if is_whole(prefix, *row)], damaged[0] if damaged else 0


def split_other_chips(prefix, options, rows):
    """Returns (chips whose libraries stay, chips whose libraries are removed) of the earlier installation, without the chips that are
    installed now. A library fits the headers that it was built with, and no others."""
    files = {name for kind, name in rows if kind == "file" and (prefix / name).is_file()}
    found = [re.fullmatch(r"lib/cds55xx/libcds55xx-(\w+)\.a", name) for name in files]
    others = sorted({match[1] for match in found if match} - {*options.mcus})
    old = {name for name in files if name.startswith("include/cds55xx/")}
    new = dict(headers())
    same = old == set(new) and all((prefix / name).read_bytes() == header.read_bytes() for name, header in new.items())
    return (others, []) if same else ([], others)


def missing_folders(prefix, names):
    """The folders that must be made, each after the one above it."""
    folders = {folder for name in names for folder in (prefix / name).parents if not folder.exists()}
    return sorted(folders, key=lambda folder: len(folder.parts))


def put(target, source):
    try:
        target.unlink(missing_ok=True) # a link is replaced, not written through
        if isinstance(source, str):
            target.write_text(source)
        else:
            shutil.copyfile(source, target)
        target.chmod(0o755 if target.parent.name == "bin" else 0o644)
    except OSError as error: # Python names no file, or the source, if the disk is full
        error.filename = error.filename2 or error.filename or target
        with contextlib.suppress(OSError):
            target.unlink()
        raise


def lines_of(rows):
    return "".join(f"{kind} {name}\n" for kind, name in rows)


def put_manifest(prefix, rows):
    """Replaces the manifest at once: a full disk or a power failure leaves the one before."""
    put(prefix / (MANIFEST + NEW), lines_of(rows))
    os.replace(prefix / (MANIFEST + NEW), prefix / MANIFEST)


def reason(error):
    return (f"{str(error.filename).removesuffix(NEW)}: " if error.filename else "") + str(error.strerror)


class Plan:
    """What an installation changes below a prefix; it changes nothing yet."""

    def __init__(self, prefix, options):
        self.prefix = prefix
        self.earlier = (prefix / MANIFEST).exists()
        self.old, self.damaged = read_manifest(prefix) if self.earlier else ([], 0) # rows of the earlier installation
        self.kept, self.removed = split_other_chips(prefix, options, self.old)
        self.sources = dict(contents(options, self.kept))
        for name in self.sources:
            if (prefix / name).is_dir():
                refuse(f"{prefix / name} is a folder, where a file must be; move it away, or name another PREFIX")
        self.missing = missing_folders(prefix, [*self.sources, MANIFEST])
        self.files = [("file", name) for name in [*self.sources, *map(library, self.kept)]]
        above = {os.path.normpath(folder) for name in self.sources for folder in (prefix / name).parents}
        self.folders = [row for row in self.old if row[0] == "folder" and os.path.normpath(prefix / row[1]) in above]
        self.folders += [("folder", os.path.relpath(folder, prefix)) for folder in self.missing]

    def write_new(self):
        """Writes the new files beside the old ones. The manifest names both."""
        for folder in self.missing:
            folder.mkdir(mode=0o755)
        new = [("file", name + NEW) for name in [*self.sources, MANIFEST]]
        put_manifest(self.prefix, [*dict.fromkeys([*self.old, *self.files, *new, *self.folders])])
        for name, source in self.sources.items():
            put(self.prefix / (name + NEW), source)
        put(self.prefix / (MANIFEST + NEW), lines_of([*self.files, *self.folders]))

    def roll_back(self):
        """Removes what write_new() has written."""
        for name in [*self.sources, MANIFEST]:
            if (self.prefix / name).parent.is_dir():
                (self.prefix / (name + NEW)).unlink(missing_ok=True)
        if not self.earlier and (self.prefix / MANIFEST).parent.is_dir():
            (self.prefix / MANIFEST).unlink(missing_ok=True)
        elif self.earlier and not self.damaged:
            with contextlib.suppress(OSError): # the manifest that is there names the earlier files, too
                put_manifest(self.prefix, self.old)
        remove_folders(self.prefix, [("folder", folder) for folder in self.missing])

    def replace_old(self):
        """Renames the new files, and removes old ones that have no successor."""
        for name in self.sources:
            os.replace(self.prefix / (name + NEW), self.prefix / name)
        for kind, name in self.old:
            if kind == "file" and ("file", name) not in self.files:
                (self.prefix / name).unlink(missing_ok=True)
        os.replace(self.prefix / (MANIFEST + NEW), self.prefix / MANIFEST)
        remove_folders(self.prefix, [row for row in self.old if row not in self.folders])


def install(prefix, options):
    """Writes all files beside those of an earlier installation, then renames them, which takes no room. Meanwhile
    the manifest names the files of both, so uninstall knows each file whenever this ends."""
    check(prefix)
    os.umask(0o022) # other users may read what is installed
    plan = Plan(prefix, options)
    try:
        plan.write_new()
    except OSError as error:
        plan.roll_back()
        refuse(f"{reason(error)}; {'the earlier installation is kept' if plan.earlier else 'nothing is installed'}: "
               "make room or set the permissions, or name another PREFIX")
    plan.replace_old()
    print(f"installed cds55xx {options.version} in {prefix} for {len(options.mcus)} chip{'s' * (len(options.mcus) > 1)}")
    for chips, text in [(plan.kept, "kept, not rebuilt: {}; to build and install them: {}"),
                        (plan.removed, "removed, since the headers have changed: {}; to install them again: {}")]:
        if chips:
            print(text.format(" ".join(chips), install_command(options, chips)))
    tell_path(prefix, options)


def install_command(options, mcus):
    """The line for the shell that installs these chips into the same prefix."""
    destdir = f"DESTDIR={shlex.quote(options.destdir)} " if options.destdir else ""
    return f"make install {destdir}PREFIX={shlex.quote(options.prefix)} MCUS=\"{' '.join(mcus)}\""


def tell_path(prefix, options):
    """Prints the line for the shell, with the variables that lack the folders of this prefix. Prints nothing if a package is made."""
    if options.destdir or str(prefix) in ("/usr", "/usr/local"):
        return
    lacking = []
    for name, folder, rest in [("PKG_CONFIG_PATH", prefix / "lib/pkgconfig", ""), ("PATH", prefix / "bin", ":$PATH")]:
        if str(folder) not in os.environ.get(name, "").split(":"):
            lacking.append(f"{name}={shlex.quote(str(folder))}{rest}")
    if lacking:
        print("type this in each new shell, or add it to ~/.profile:\nexport " + " ".join(lacking))


def remove_folders(prefix, rows):
    for kind, name in reversed(rows):
        if kind == "folder":
            with contextlib.suppress(OSError): # it has files of others
                pathlib.Path(os.path.normpath(prefix / name)).rmdir() # `name` may be `..`


def uninstall(prefix):
    manifest = prefix / MANIFEST
    if not manifest.exists():
        refuse(f"nothing is installed in {prefix}; name the prefix of the installation: make uninstall PREFIX=...")
    if not os.access(manifest.parent, os.W_OK):
        refuse(f"{prefix} may not be written by {user()}; use sudo")
    rows, damaged = read_manifest(prefix)
    if damaged:
        refuse(f"{manifest}, line {damaged} is damaged, nothing is removed; make install into the same PREFIX writes "
               "it anew, then make uninstall")
    for kind, name in rows:
        if kind == "file":
            (prefix / name).unlink(missing_ok=True)
    manifest.unlink()
    remove_folders(prefix, rows)
    print(f"removed cds55xx from {prefix}: {sum(kind == 'file' for kind, _ in rows)} files")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("order", choices=["check", "install", "uninstall"])
    parser.add_argument("--prefix", required=True)
    parser.add_argument("--destdir", default="")
    parser.add_argument("--mcus", type=str.split, default=[])
    parser.add_argument("--cflags", default="")
    parser.add_argument("--ldflags", default="")
    options = parser.parse_args()
    options.version = version()
    if not os.path.isabs(options.prefix):
        refuse(f"PREFIX={options.prefix} is not absolute; name it from / on")
    # pkg-config prints other letters with a backslash, which the shell does not take away; `:` ends a folder of its path.
    letter = re.search(r"[^A-Za-z0-9/._+,=@~-]", options.prefix)
    if letter and options.order != "uninstall":
        refuse(f"PREFIX={options.prefix} has '{letter[0]}'; use ASCII letters, digits and /._+,=@~- only, or no program can link")
    prefix = pathlib.Path(options.destdir + options.prefix) # as in GNU make: the one before the other
    if ".." in prefix.parts: # the folder before it need not exist
        prefix = pathlib.Path(os.path.realpath(prefix))
    try:
        if options.order == "check":
            check(prefix)
        elif options.order == "install":
            install(prefix, options)
        else:
            uninstall(prefix)
    except OSError as error:
        refuse(reason(error))


if __name__ == "__main__":
    main()
