"""Coefficients of the internal resonance, derived from the energy of the cable by computer algebra."""

import sympy as sp


def test_energy_of_the_cable_gives_the_coefficients():
    """T0 (l - 1) + K (l - 1)^2 / 2 with the local stretch l: its cubic part has K - T0 = EA, Eq. (A.10)."""
    u, s, tension, stiffness = sp.symbols("u s T0 K", positive=True)
    eps = sp.symbols("epsilon")
    local = sp.sqrt((1 + eps**2 * u) ** 2 + eps**2 * s) - 1
    energy = sp.series(tension * local + stiffness * local**2 / 2, eps, 0, 7).removeO()
    cubic = sp.expand(energy).coeff(eps, 4)
    assert sp.simplify(cubic - (stiffness * u**2 / 2 + (stiffness - tension) * (u * s / 2 + s**2 / 8))) == 0


def test_slaved_longitudinal_modes_give_the_stiffening():
    """Least K u'^2/2 + EA u' s/2 + EA s^2/8 over u between held ends, s = (kappa a cos)^2: Eq. (A.11)."""
    x, a, kappa, rigidity, tension = sp.symbols("x a kappa EA T0", positive=True)
    length, stiffness = sp.pi / kappa, rigidity + tension
    s = (kappa * a * sp.cos(kappa * x)) ** 2
    mean = sp.integrate(s, (x, 0, length)) / length
    strain = -rigidity / (2 * stiffness) * (s - mean)
    density = stiffness * strain**2 / 2 + rigidity * strain * s / 2 + rigidity * s**2 / 8
    energy = sp.integrate(sp.expand(density), (x, 0, length))
    rho = sp.symbols("rho", positive=True)
    beta = sp.diff(energy, a) / a**3 / (rho * length / 2)
    expected = rigidity * (rigidity + sp.Rational(3, 2) * tension) * kappa**4 / (4 * rho * stiffness)
    assert sp.simplify(beta - expected) == 0
