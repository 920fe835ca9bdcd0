r"""Tension of the drive at rest when its line is inclined: the upper end carries what is below it."""

from cabledrive.parameters.drive import Drive


def lowest_static_tension(drive: Drive) -> float:
    r"""Lowest tension on the cable at rest, the drive pulley held, the load pulley free unless it is fixed.

    Gravity along the line, from drive to load, is :math:`g_s = -g\sin\varphi`. At distance s from the drive
    pulley a span carries the mass M(s) between there and the load pulley,

    .. math:: T(s) = \sigma + g_s\,M(s), \qquad \frac{1}{N L}\sum_{spans}\int_0^L T\,ds = T_0
              \;\Rightarrow\;
              \sigma = T_0 - \frac{g_s}{N}\sum_{spans}\Big(\tfrac12\rho_0 L + \sum_i m_i\frac{x_i}{L}\Big),

    because the stretch of all N spans together stays what the pretension made it (:math:`x_i` is the distance
    of carriage i from the drive pulley). A fixed load pulley keeps the stretch of each span apart. The lowest
    tension is at the lower end. Sag and friction are left out.

    Returns lowest tension [N]; zero or less means that a span hangs slack at rest.
    """
    length = drive.span_length
    pull = -drive.layout.gravity_along
    masses, moments = [], []
    for span in drive.spans:
        carriages = drive.carriages_on(span)
        from_drive = [c.position if span == "upper" else length - c.position for c in carriages]
        masses.append(drive.cable.mass_per_length * length + sum(c.mass for c in carriages))
        moment = sum(c.mass * x for c, x in zip(carriages, from_drive, strict=True))
        moments.append(drive.cable.mass_per_length * length / 2.0 + moment / length)
    if not drive.load_pulley.fixed:
        moments = [sum(moments) / len(moments)] * len(moments)
    at_load = [drive.cable.pretension - pull * moment for moment in moments]
    return min(t + min(0.0, pull * mass) for t, mass in zip(at_load, masses, strict=True))
