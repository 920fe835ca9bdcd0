"""Somebody's own log becomes a page with its numbers, its data check and the figures of chapter 4."""

import numpy as np
import pytest

from cabledrive.identification.axis.axis import identify_rigid_axis
from cabledrive.parameters import InputRefused
from cabledrive.report.log_page import write_log_report
from cabledrive.rig.bench.virtual_rig import BENCH_TESTS, Imperfections, bench_command, bench_rig, run_rig
from report_page import TIME, Reader


@pytest.fixture(scope="module")
def log():
    from dataclasses import replace

    test, rng = replace(BENCH_TESTS[1], duration=12.0), np.random.default_rng(5)
    return run_rig(bench_rig(test, Imperfections(torque_noise=0.002)), bench_command(test, rng), rng)


@pytest.fixture(scope="module")
def found(log):
    return identify_rigid_axis([log])


def test_the_page_is_sound_and_says_what_was_found(log, found, tmp_path):
    (tmp_path / "a.csv").write_text("x")
    path = write_log_report(log, found, tmp_path / "a.html", files=[tmp_path / "a.csv"], written_at=TIME)
    page = Reader(path.read_text(encoding="utf-8"))
    assert page.faults == []
    assert sum("table" not in f.attributes.get("class", "") for f in page.root.all("figure")) == 2
    words = page.root.text
    for expected in ("coulomb friction", "12000 rows", "no repairs", "a.csv", "Residual"):
        assert expected in words, expected
    with pytest.raises(InputRefused, match="exists"):
        write_log_report(log, found, tmp_path / "a.html")


@pytest.mark.verify
def test_chapter_4_is_identified_as_its_rig_was_made(measured):
    """99.9 % intervals at the seed of the report; the coupling within 99.9 %; the amplifier within 95 %."""
    from scipy import stats

    from cabledrive.studies.chapter_4 import chapter_4

    found = chapter_4()
    values = []
    for one in found.experiments:
        truth = (one.test.inertia, one.test.viscous, one.test.coulomb, one.test.offset)
        t = stats.t.ppf(0.9995, one.found.freedom)
        for (name, estimate), value in zip(one.found.parameters.items(), truth, strict=True):
            values.append((one.title, name, estimate, value, t))
    inside = sum(estimate.low < value < estimate.high for _, _, estimate, value, _ in values)
    km, bm = (found.coupled.fit.bounds(name, 0.95) for name in ("joint_stiffness", "joint_damping"))
    measured(
        f"{inside} of {len(values)} values in their 95 % intervals; k_m {km[0]:.0f} to {km[1]:.0f} N m/rad, "
        f"b_m {bm[0]:.3f} to {bm[1]:.3f} N m s/rad; amplifier {found.amplifier.decibels:.3f} dB"
    )
    for title, name, estimate, value, t in values:
        assert abs(estimate.value - value) < t * estimate.standard_error, (title, name, estimate)
    for name, value in (("joint_stiffness", 135.0), ("joint_damping", 0.075)):
        low, high = found.coupled.fit.bounds(name, 0.999)
        assert low < value < high, (name, low, high)
    assert found.amplifier.decibels == pytest.approx(4.2, abs=0.01)
    tanh = found.experiments[-1].printed_regressor
    assert tanh["viscous_friction"] < 0.0, "tanh(0.5 w) does not part the frictions of a slow axis"
