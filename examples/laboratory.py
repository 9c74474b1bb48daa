"""Write laboratory.txt: a simulated scan as the program of a German laboratory would record it.

The file has Latin-1 encoding, semicolons, decimal commas, lines before the titles, a row of units,
and forces in mN. The transducer is turned by 90 degrees, so that its x axis is normal to the
surface, and its origin is 20 mm below the clamp. Its channels have offsets, and the position of
the stage was not recorded. The rod is lowered onto the surface, rests, is moved at 1 mm/s, rests
again and is lifted off.
"""

import sys
from pathlib import Path

import numpy as np

from vibrissa.scanning import surfaces
from vibrissa.sensor import Setup, scan

FRICTION, RATE, STEP = 0.3, 50, "20 um"
NOISE = np.array([3e-3, 3e-3, 6e-5])
ZEROS = np.array([0.12, -0.31, 2.4e-3])
BELOW = 0.02
HEAD = """Prüfstand Tasthaar;Kraftaufnehmer Nr. 17
Prüfer;Müller
Datum;12.03.2026
Meßrate;50 Hz
Temperatur in °C;23,4

Zeit;Kraft Fx;Kraft Fy;Moment Mz
s;mN;mN;Nmm
"""
WHISKER = Setup.read(
    theta=2, eta="85 mm", modulus="210 GPa", diameter="0.8 mm", length="100 mm"
).whisker


def loads() -> np.ndarray:
    """Load on the clamp before, during and after the scan, shape (n, 3), in SI units."""
    signals = scan(
        WHISKER,
        surfaces.constant(FRICTION),
        step=STEP,
        to=["15 mm"],
        law="kinetic",
        kinetic_ratio=0.8,
    )
    moved = signals.readings
    first, last = moved[0], moved[-1]
    lowered, lifted = np.linspace(0, 1, RATE)[:, None], np.linspace(1, 0, RATE // 2)[:, None]
    free, rest = np.zeros((2 * RATE, 3)), np.ones((2 * RATE, 1))
    return np.concatenate(
        [free, lowered * first, rest * first, moved, rest * last, lifted * last, free]
    )


def readings() -> np.ndarray:
    """Readings of the transducer: turned axes, moment about its own origin, offsets and noise."""
    fx, fy, moment = loads().T
    # The moment about (a, b) is the moment about the clamp minus (a·fy − b·fx); a = 0, b = −BELOW.
    moment = moment - BELOW * fx
    turned = np.stack([fy, -fx, moment], axis=1)
    noise = np.random.default_rng(1).standard_normal(turned.shape) * NOISE
    return turned + ZEROS + noise


def main(folder: Path) -> None:
    """Write the file."""
    lines = [
        ";".join(
            [f"{row / RATE:.2f}", *(f"{value:.2f}" for value in reading * [1e3, 1e3, 1e3])]
        ).replace(".", ",")
        for row, reading in enumerate(readings())
    ]
    text = HEAD + "\n".join(lines) + "\n"
    (folder / "laboratory.txt").write_bytes(text.replace("\n", "\r\n").encode("latin-1"))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if sys.argv[1:] else Path(__file__).parent)
