#!/usr/bin/env python3
"""Finds the PLL settings nearest to the gateware's clock: boards/clock.py FAMILY OSCILLATOR_KHZ PHASE_BITS

Prints the parameters of the family's top, one NAME=VALUE per line, and the resulting clock on standard error.
The clock is 40.96 MHz, or 81.92 MHz with 8 phase bits: 40 kHz * 1024 or 2048.
"""

import sys
from fractions import Fraction


def ecp5(khz):
    """EHXPLLL with CLKOS as feedback: 10 MHz at the phase detector at least, 400 to 800 MHz at the VCO."""
    for pll in range(1, 129):
        if khz / pll < 10_000:
            break
        for multiply in range(1, 129):
            if 400_000 <= khz * multiply / pll <= 800_000:
                for out in range(1, 129):
                    yield {"PLL_DIVIDE": pll, "MULTIPLY": multiply, "OUT_DIVIDE": out}


def gowin(khz):
    """rPLL with CLKOUTD: 3 MHz at the phase detector at least, 500 to 1200 MHz at the VCO, up to 500 MHz at CLKOUT."""
    for pll in range(1, 65):
        if khz / pll < 3_000:
            break
        for multiply in range(1, 65):
            clkout = khz * multiply / pll
            vco = [n for n in (2, 4, 8, 16, 32, 48, 64, 80, 96, 112, 128) if 500_000 <= clkout * n <= 1_200_000]
            if vco and clkout <= 500_000:
                for out in range(2, 129, 2):
                    yield {"PLL_DIVIDE": pll, "MULTIPLY": multiply, "OUT_DIVIDE": out, "VCO_DIVIDE": vco[0]}


def xc6slx9(khz):
    """DCM_CLKGEN: one multiplier and one divider, for oscillators from 0.5 MHz."""
    for multiply in range(2, 257):
        for divide in range(1, 257):
            yield {"MULTIPLY": multiply, "DIVIDE": divide}


def clock(khz, settings):
    divide = settings.get("DIVIDE", settings.get("PLL_DIVIDE", 1) * settings.get("OUT_DIVIDE", 1))
    return Fraction(khz * settings["MULTIPLY"], divide)


def main():
    families = {"ecp5": ecp5, "gowin": gowin, "xc6slx9": xc6slx9}
    try:
        family, khz, bits = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
        found = families[family](khz)
        if not (5 <= bits <= 8 and 5_000 <= khz <= 200_000):
            raise ValueError
    except (IndexError, KeyError, ValueError):
        sys.exit(f"usage: {sys.argv[0]} {'|'.join(families)} OSCILLATOR_KHZ PHASE_BITS (5000 to 200000 kHz, 5 to 8 bits)")
    clocks = 2048 if bits == 8 else 1024
    # The first of equals has the fewest divisions before the phase detector.
    best = min(found, default=None, key=lambda settings: abs(clock(khz, settings) - 40 * clocks))
    if best is None or abs(clock(khz, best) / clocks - 40) > Fraction(1, 2):
        sys.exit(f"clock.py: no settings of this PLL bring {khz} kHz within 500 Hz of a carrier of 40 kHz")
    print(*(f"{name}={value}" for name, value in best.items()), sep="\n")
    mhz = clock(khz, best) / 1000
    print(f"clock {float(mhz):.4f} MHz, carrier {float(mhz * 1_000_000 / clocks):.2f} Hz", file=sys.stderr)


main()
