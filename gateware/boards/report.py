#!/usr/bin/env python3
"""Writes a row of resources.md from nextpnr's report; fails if the clock is too slow:

    boards/report.py REPORT BOARD PHASE_BITS SETTINGS…

SETTINGS is the output of `settings` in tools.sh. The row goes to standard output: board, phase bits, clock required and
reached in MHz, then LUT, FF, block RAMs and multipliers used.
"""

import json
import sys

CELLS = {
    "lut": ("TRELLIS_COMB", "LUT4", "ALU"),
    "ff": ("TRELLIS_FF", "DFF"),
    "ram": ("DP16KD", "BSRAM"),
    "dsp": ("MULT18X18D", "MULT9X9", "MULT18X18"),
}

path, board, bits, *words = sys.argv[1:]
report = json.load(open(path))
known = {name: int(value) for name, value in zip(words[1::3], words[2::3]) if value.isdigit()}
needed = known["OSCILLATOR_KHZ"] / 1000 * known["MULTIPLY"] / known["PLL_DIVIDE"] / known["OUT_DIVIDE"]
reached = min(clock["achieved"] for clock in report["fmax"].values())
used = [sum(report["utilization"].get(cell, {}).get("used", 0) for cell in cells) for cells in CELLS.values()]
print(board, bits, f"{needed:.2f}", f"{reached:.1f}", *used, sep="\t")
if reached < needed:
    sys.exit(f"{board}, {bits} phase bits: {reached:.1f} MHz reached, {needed:.2f} MHz needed")
