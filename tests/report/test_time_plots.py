"""A plot over time keeps its ends and every peak, however few instants it shows."""

import numpy as np

from cabledrive.report.plot import Panel, Series
from cabledrive.report.time_plots import time_plot


def test_a_thinned_plot_keeps_ends_and_peaks_of_every_curve():
    time = np.linspace(0.0, 10.0, 100_001)
    calm, spiked = np.sin(time), np.zeros_like(time)
    spiked[[12_345, 77_777]] = 5.0, -7.0
    panels = [
        Panel(title="one", unit="N", series=(Series(name="calm", values=calm),)),
        Panel(title="two", unit="N", series=(Series(name="spiked", values=spiked),)),
    ]
    plot = time_plot("x", time, panels, alt="two curves", caption="")
    assert plot.points.size < 1_100
    assert plot.points[[0, -1]].tolist() == [0.0, 10.0]
    shown = plot.panels[1].series[0].values
    assert (shown.max(), shown.min()) == (5.0, -7.0)
    assert plot.points[np.argmax(shown)] == time[12_345]
    assert plot.panels[0].series[0].values.max() == calm.max()
