"""Figures of the periods of scans."""

import numpy as np
import pytest

from figure_rows import teeth
from vibrissa.figures.periods import amplitudes, spectrum


@pytest.mark.parametrize("frequency", [5.0, 12.25])
def test_a_sine_has_its_amplitude_at_its_frequency(frequency):
    places = np.arange(4000) * 0.001
    found = amplitudes(3.0 + 0.7 * np.sin(2.0 * np.pi * frequency * places), 0.001)
    peak = int(np.argmax(found.amplitude))
    assert found.frequency[peak] == pytest.approx(frequency, abs=0.13)
    assert found.amplitude[peak] == pytest.approx(0.7, rel=0.05)
    assert found.amplitude[0] < 0.01


def test_each_law_has_its_line_in_the_spectrum():
    (panel,) = spectrum(teeth(4), by="law").axes
    peaks = {
        line.get_label(): line.get_xdata()[np.argmax(line.get_ydata())] for line in panel.lines
    }
    # 4, 5 and 8 teeth in 0.4 L.
    assert peaks == pytest.approx({"energy": 10.0, "free": 12.5, "kinetic": 20.0}, abs=1.3)
