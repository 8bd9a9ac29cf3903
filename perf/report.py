#!/usr/bin/env python3
"""One self-contained HTML page about a run: python3 report.py DIR [--out FILE] (default DIR/report.html), or about many:
report.py DIR DIR ... --index FILE [--figures NAME,NAME].

Called by `talus report`. Reads what a run leaves (summary.json, scene.toml, series.csv, frames of particles and walls);
whatever is missing or unreadable is named on the page and left out, so that it also shows a run that goes on or was
killed. No external resources, no dates: the same folder gives the same page.
"""
import argparse
import contextlib
import os
import signal
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(os.path.dirname(HERE), "cases")]
try:
    import matplotlib  # noqa: F401
    import numpy  # noqa: F401
except ImportError as missing:
    sys.exit(f"error: the report needs {missing.name} (apt-get install python3-{missing.name})")
from report.index import UnknownFigure, index_page  # noqa: E402
from report.page import page  # noqa: E402


def fail(what):
    print(f"error: {what}", file=sys.stderr)
    return 5


def write(target, text):
    if os.path.lexists(target):
        if not os.path.isfile(target):
            raise OSError(0, "is no regular file")
        with open(target, "rb") as f:
            if not f.read(15).lower().startswith(b"<!doctype html>"):
                raise OSError(0, "the file that is there is no HTML page; give another name")
    # The mark of all scratch files of Talus (core/io/scratch.hpp); "x": nobody else's file is opened.
    scratch = os.path.join(os.path.dirname(target), ".talus-" + os.urandom(8).hex())
    try:
        with open(scratch, "x", encoding="utf-8") as f:
            f.write(text)
        os.replace(scratch, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(scratch)
        raise


def main():
    parser = argparse.ArgumentParser(description="Write one self-contained HTML page about a run, or an index of many.")
    parser.add_argument("folders", metavar="DIR", nargs="+", help="output folder of talus run")
    parser.add_argument("--out", metavar="FILE", help="page to write (default DIR/report.html)")
    parser.add_argument("--index", metavar="FILE", help="one page about all the folders")
    parser.add_argument("--figures", metavar="NAMES", help="of the index: names of the summary or of columns, separated by commas")
    arguments = parser.parse_args()
    for folder in arguments.folders:
        if not os.path.isdir(folder):
            return fail(f"{folder}: is not a folder (give the folder that talus run wrote)")
    if arguments.index is None and len(arguments.folders) > 1:
        return fail("several folders make an index: give --index FILE")
    target = arguments.index or arguments.out or os.path.join(arguments.folders[0], "report.html")
    try:
        if arguments.index:
            text = index_page(arguments.folders, target, [n for n in (arguments.figures or "").split(",") if n])
        else:
            text = page(arguments.folders[0])
        write(target, text)
    except UnknownFigure as error:
        return fail(f"--figures: {error}")
    except OSError as error:
        return fail(f"{target}: cannot write: {error.strerror}")
    try:
        print(target, flush=True)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # the interpreter flushes once more at its end
        if isinstance(error, BrokenPipeError):  # nobody reads it: as talus itself
            return 128 + signal.SIGPIPE
        return fail(f"standard output: cannot write: {error.strerror}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
