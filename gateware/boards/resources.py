#!/usr/bin/env python3
"""Compares the reports of the boards' builds with gateware/resources.md, or rewrites its table:

    boards/resources.py check|write ROW_FILE …

A row of a ROW_FILE is the output of boards/report.py. `check` fails if a build differs from the table by more than the
noise of placement.
"""

import pathlib
import sys

FILE = pathlib.Path(__file__).resolve().parent.parent / "resources.md"
HEAD = ("| board | phase bits | clock needed, MHz | reached, MHz | slack, ns | LUT | FF | block RAMs | multipliers |\n"
        "|---|---|---|---|---|---|---|---|---|\n")


def built(paths):
    return [tuple(line.split("\t")) for path in paths for line in pathlib.Path(path).read_text().splitlines()]


def known(text):
    """The rows of the table by board and phase bits."""
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.split(HEAD)[1].splitlines() if line.startswith("|")]
    return {(row[0], row[1]): row for row in cells}


def line(board, bits, needed, reached, *used):
    slack = "-" if reached == "-" else f"{1000 / float(needed) - 1000 / float(reached):.1f}"
    return "| " + " | ".join([board, bits, needed, reached, slack, *used]) + " |"


def faults(row, said):
    board, bits, _, reached, lut, ff, ram, dsp = row
    for name, now, then in (("LUT", lut, said[5]), ("FF", ff, said[6])):
        if float(now) > 1.05 * float(then):
            yield f"{now} {name}, the table has {then}"
    if [ram, dsp] != said[7:9]:
        yield f"{ram} block RAMs and {dsp} multipliers, the table has {said[7]} and {said[8]}"
    if reached != "-" and float(reached) < 0.85 * float(said[3]):
        yield f"{reached} MHz, the table has {said[3]}"


def main():
    if len(sys.argv) < 3 or sys.argv[1] not in ("check", "write"):
        sys.exit(f"usage: {sys.argv[0]} check|write ROW_FILE ...")
    rows, text = built(sys.argv[2:]), FILE.read_text()
    if sys.argv[1] == "write":
        before, _, rest = text.partition(HEAD)
        after = rest[rest.index("\n\n"):] if "\n\n" in rest else "\n"
        FILE.write_text(before + HEAD + "\n".join(line(*row) for row in rows) + after)
        return
    table, wrong = known(text), []
    for row in rows:
        said = table.get(row[:2])
        found = list(faults(row, said)) if said else ["not in the table"]
        wrong += [f"{row[0]}, {row[1]} phase bits: {fault}" for fault in found]
        print("as in resources.md:" if not found else "differs:", *row)
    if wrong:
        sys.exit("\n".join(wrong) + "\nif this is meant, gateware/check --long rewrites gateware/resources.md")


main()
