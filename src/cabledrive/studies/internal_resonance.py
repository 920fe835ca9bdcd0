"""Internal resonance of any machine: a loop or a line, or one with routes."""

from cabledrive.parameters import Drive
from cabledrive.parameters.route.drive import RoutedDrive, refuse_route
from cabledrive.studies.resonance import ResonanceSummary
from cabledrive.studies.resonance import resonance as resonance_of_loop
from cabledrive.studies.route_pairs import RouteResonance, route_resonance


def resonance(
    drive: Drive | RoutedDrive,
    *,
    torque: float | None = None,
    load_torque: float = 0.0,
    details: bool = True,
) -> ResonanceSummary | RouteResonance:
    """Frequency ratio, threshold torque, pairs near resonance and verdict of a machine.

    Parameters
    ----------
    drive : Drive or RoutedDrive
    torque : float, optional
        Amplitude of the verdict [N m]; default: that of the file's [excitation]. Where there is neither, the
        verdict is "no excitation given", and the figures of a loop or a line are those at its torque limit
        or, without one, 1 % of the slack torque.
    load_torque : float, default 0.0
        Steady torque on the load pulley [N m], which splits the tuning of the spans; on loops and lines.
    details : bool, default True
        Whether to list the pairs of a loop or a line, and to find its torque of tenfold growth, which take
        most of the time.

    Returns
    -------
    ResonanceSummary or RouteResonance
        The second of a machine with routes: its pairs near 1:2 and of sum type, Eq. (N.11).

    Raises
    ------
    InputRefused
        If the torque is negative, the steady one takes a span's tension away, or a cable runs.
    NotComputed
        If a span hangs slack at rest.
    """
    if not isinstance(drive, RoutedDrive):
        return resonance_of_loop(drive, torque=torque, load_torque=load_torque, details=details)
    if load_torque:
        refuse_route("`resonance` under a load torque")
    return route_resonance(drive, torque=torque)
