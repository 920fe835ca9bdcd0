"""Names of the printed errors lie on no curve, on wide pages and on narrow ones."""

import numpy as np
import pytest

from cabledrive.report import picture as pictures
from cabledrive.report.control_figures import PRINTED_ERRORS
from cabledrive.report.figures.control_curves import Curve, curves_picture

CURVES = (
    Curve(
        words="rise time [s]",
        values=(0.3, 0.4, 0.5, 0.6, 0.7, 1.0),
        errors={
            "darc-3": (0.55, 0.27, 0.154, 0.101, 0.081, 0.088),
            "darc-4": (0.33, 0.144, 0.0755, 0.0455, 0.0275, 0.06),
            "backstepping": (0.46, 0.168, 0.104, 0.097, 0.081, 0.147),
            "darc-4-damped": (0.0068, 0.0059, 0.0065, 0.0168, 0.012, 0.035),
        },
    ),
    Curve(
        words="angle [deg]",
        values=(10.0, 22.5, 45.0, 67.5, 90.0),
        errors={
            "darc-3": (0.132, 0.095, 0.153, 0.232, 0.31),
            "darc-4": (0.056, 0.0465, 0.0755, 0.112, 0.15),
            "backstepping": (0.127, 0.083, 0.104, 0.116, 0.193),
            "darc-4-damped": (0.033, 0.034, 0.0065, 0.0255, 0.0066),
        },
    ),
    Curve(
        words="bandwidth [Hz]",
        values=(8.0, 11.0, 14.0, 18.0, 23.0, 28.0, 35.0),
        errors={
            "darc-3": (0.225, 0.153, 0.131, 0.0745, 0.052, 0.0415, 0.0333),
            "darc-4": (np.nan, np.nan, 0.34, 0.15, 0.0755, 0.0545, 0.038),
            "backstepping": (0.176, 0.121, 0.066, 0.052, 0.0535, 0.051, 0.0455),
            "darc-4-damped": (np.nan, 0.485, 0.112, 0.128, 0.0065, 0.0131, 0.0198),
        },
    ),
)


@pytest.fixture
def figures(monkeypatch):
    """The wide figure and the narrow one, drawn."""
    drawn, found = pictures._drawn, []

    def keep(name, paint, narrow, size):
        def painted(figure, narrow):
            paint(figure, narrow)
            figure.draw_without_rendering()
            found.append(figure)

        return drawn(name, painted, narrow, size)

    monkeypatch.setattr(pictures, "_drawn", keep)
    curves_picture("errors", CURVES, PRINTED_ERRORS)
    return found


@pytest.mark.verify
@pytest.mark.parametrize(("place", "named"), [(0, 1), (1, 3)], ids=["wide", "narrow"])
def test_no_curve_passes_through_the_name_of_a_printed_error(figures, place, named):
    panels = [axes for axes in figures[place].axes if axes.texts]
    assert len(panels) == named
    for axes in panels:
        assert [text.get_text() for text in axes.texts] == list(PRINTED_ERRORS)
        curves = [line for line in axes.lines if line.get_transform() == axes.transData]
        assert len(curves) == 4
        boxes = [text.get_window_extent() for text in axes.texts]
        for text, box in zip(axes.texts, boxes, strict=True):
            assert axes.get_window_extent().padded(1.0).contains(*box.min), text
            for curve in curves:
                across = curve.get_path().transformed(axes.transData).intersects_bbox(box, filled=False)
                assert not across, f"{text.get_text()} lies on a curve, {axes.get_xlabel()}"
        assert not any(a is not b and a.overlaps(b) for a in boxes for b in boxes)
