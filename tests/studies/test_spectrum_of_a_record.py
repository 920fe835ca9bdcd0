"""A spectrum shows sines with their own amplitude and frequency."""

import numpy as np
import pytest

from cabledrive.parameters import InputRefused
from cabledrive.studies.spectrum import amplitude_spectrum

TIME = np.arange(4000) / 2000.0


def test_a_sine_shows_at_its_frequency_with_its_amplitude():
    """On an even line, which does not count; between two lines of the unpadded transform."""
    signal = 3.0 * np.sin(2.0 * np.pi * 81.73 * TIME + 0.4) + 7.0 + 50.0 * TIME
    spectrum = amplitude_spectrum(TIME, signal)
    frequency, amplitude = spectrum.peak(70.0, 95.0)
    assert frequency == pytest.approx(81.73, abs=1e-3), frequency
    assert amplitude == pytest.approx(3.0, rel=2e-3), amplitude
    assert spectrum.resolution == pytest.approx(0.5)


def test_a_record_too_short_or_a_band_too_narrow_is_refused():
    with pytest.raises(InputRefused, match="spectrum of 5 samples"):
        amplitude_spectrum(TIME[:5], TIME[:5])
    with pytest.raises(InputRefused, match=r"band from 80 to 80\.01 Hz"):
        amplitude_spectrum(TIME, np.sin(TIME)).peak(80.0, 80.01)
