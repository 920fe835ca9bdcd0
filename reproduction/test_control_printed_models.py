"""Errata of Section 6.2 and of the state forms (6.39), (6.47), (6.58), (6.66): the four reduced models.

The equations of motion are derived here from the energy, the dissipation and the torque at the motor, and the
printed formulas are held against them as rational functions: an identity leaves exactly zero.
"""

import sympy as sp

s = sp.Symbol("s")
J1, J2, J11, J12, k, r, k_m = sp.symbols("J1 J2 J11 J12 k r k_m", positive=True)
b_1, b_c, b_m = sp.symbols("b_1 b_c b_m", nonnegative=True)
net = sp.Symbol("tau_c")  # motor torque less Coulomb friction, plus the offsets
kk, bb = 2 * k * r**2, 2 * b_c * r  # two cable spans seen as one rotational spring and damper


def is_zero(expression):
    return sp.cancel(sp.together(expression)) == 0


def accelerations(inertias, theta, omega, potential, dissipation):
    """J_i theta_i'' = -dU/dtheta_i - dR/domega_i, with the net torque at the motor, theta[0]."""
    torques = [-sp.diff(potential, q) - sp.diff(dissipation, w) for q, w in zip(theta, omega, strict=True)]
    torques[0] += net
    return [torque / inertia for torque, inertia in zip(torques, inertias, strict=True)]


th11, th12, th1, th2 = sp.symbols("theta_11 theta_12 theta_1 theta_2")
om11, om12, om1, om2 = sp.symbols("omega_11 omega_12 omega_1 omega_2")


def model_2(b_m=b_m):
    """Flexible motor joint, rigid cable, Eq. (6.10): motor and both pulleys."""
    joint, twisting = k_m * (th11 - th12) ** 2 / 2, b_m * (om11 - om12) ** 2 / 2
    return accelerations([J11, J2 + J12], [th11, th12], [om11, om12], joint, twisting + b_1 * om11**2 / 2)


def model_3(b_c=b_c):
    """Rigid motor joint, flexible cable, Eq. (6.11)."""
    cable, stretching = kk * (th1 - th2) ** 2 / 2, 2 * b_c * r * (om1 - om2) ** 2 / 2
    return accelerations([J1, J2], [th1, th2], [om1, om2], cable, stretching + b_1 * om1**2 / 2)


def model_4(b_m=b_m, b_c=b_c):
    """Flexible motor joint and cable, Eq. (6.13)."""
    potential = k_m * (th11 - th12) ** 2 / 2 + kk * (th12 - th2) ** 2 / 2
    dissipation = b_m * (om11 - om12) ** 2 / 2 + b_c * r * (om12 - om2) ** 2 + b_1 * om11**2 / 2
    return accelerations([J11, J12, J2], [th11, th12, th2], [om11, om12, om2], potential, dissipation)


def transfer(accelerations, theta, omega):
    """Angles over tau_c in the Laplace domain."""
    motion = {w: s * q for q, w in zip(theta, omega, strict=True)}
    equations = [s**2 * q - a.subs(motion) for q, a in zip(theta, accelerations, strict=True)]
    solution = sp.solve(equations, theta, dict=True)[0]
    return [sp.cancel(solution[q] / net) for q in theta]


# --- transfer functions -----------------------------------------------------------------------------------


def test_eq_6_12_is_the_transfer_function_of_6_11():
    """`confirmed-6-12`: as printed, from the equations of motion."""
    printed = ((s**2 + bb / J2 * s + kk / J2) / J1) / (
        s**3
        + ((b_1 + bb) / J1 + bb / J2) * s**2
        + (kk / J1 + kk / J2 + b_1 * bb / (J1 * J2)) * s
        + kk * b_1 / (J1 * J2)
    )
    angle = transfer(model_3(), [th1, th2], [om1, om2])[0]
    assert is_zero(s * angle - printed)


def cable_factor():
    return s**2 + bb / J2 * s + kk / J2


def printed_denominator_of_6_14():
    return (
        s**4
        + (bb / J2 + b_m / J12 + bb / J12) * s**3
        + (kk / J2 + bb * b_m / (J12 * J2) + kk / J12) * s**2
        + kk * b_m / (J12 * J2) * s
    )


def corrected_denominator_of_6_14():
    return (
        s**4
        + (bb / J2 + bb / J12 + b_m / J12) * s**3
        + (kk / J2 + kk / J12 + k_m / J12 + bb * b_m / (J12 * J2)) * s**2
        + (bb * k_m + b_m * kk) / (J12 * J2) * s
        + kk * k_m / (J12 * J2)
    )


def drive_over_motor():
    """G_1 = theta_12 / theta_11 of (6.13b, c), the motor angle prescribed."""
    motion = {om11: s * th11, om12: s * th12, om2: s * th2}
    _, a12, a2 = (a.subs(motion) for a in model_4())
    solution = sp.solve([s**2 * th12 - a12, s**2 * th2 - a2], [th12, th2], dict=True)[0]
    return sp.cancel(solution[th12] / th11)


def test_eq_6_14_first_line_needs_k_m_over_b_m_and_the_terms_with_k_m():
    """`erratum-6-14-first-line`: the print is the denominator for k_m = 0, with an integrator."""
    true = drive_over_motor()
    corrected = b_m / J12 * (s + k_m / b_m) * cable_factor() / corrected_denominator_of_6_14()
    printed = b_m / J12 * (s + b_m / k_m) * cable_factor() / printed_denominator_of_6_14()
    other_numerator = b_m / J12 * (s + k_m / b_m) * cable_factor() / printed_denominator_of_6_14()

    assert is_zero(true - corrected)
    assert not is_zero(true - printed)
    assert not is_zero(true - other_numerator)

    assert is_zero(printed_denominator_of_6_14() - corrected_denominator_of_6_14().subs(k_m, 0))
    assert sp.limit(true, s, 0) == 1, "motor and drive pulley turn together at rest"
    assert printed_denominator_of_6_14().subs(s, 0) == 0, "the print has an integrator there"


def test_eq_6_14_second_line_divides_the_coupling_by_the_motor_inertia():
    """`erratum-6-14-second-line`: theta_11 comes out only with G_1 b_m (s + k_m/b_m)/J11."""
    true = s * transfer(model_4(), [th11, th12, th2], [om11, om12, om2])[0]
    own, coupling = s**2 + (b_1 + b_m) / J11 * s + k_m / J11, drive_over_motor() * b_m * (s + k_m / b_m)

    assert is_zero(true - (s / J11) / (own - coupling / J11))
    assert not is_zero(true - (s / J11) / (own - coupling))


# --- state forms ------------------------------------------------------------------------------------------

x1, x2, x3, x4, x5, x6 = sp.symbols("x1:7")
MODEL_2_STATES = {th12: x1, om12: x2, th11: x1 + x3, om11: x2 + x4}  # (6.38)
MODEL_3_STATES = {th2: x1, om2: x2, th1: x1 + x3, om1: x2 + x4}  # (6.46)
MODEL_4_STATES = {
    th2: x1,
    om2: x2,
    th12: x1 + x3,
    om12: x2 + x4,
    th11: x1 + x3 + x5,
    om11: x2 + x4 + x6,
}  # (6.57)


def state_form_2(accelerations):
    """x2' and x4bar' of (6.38), beta = k_m / (J2 + J12)."""
    motor, pulleys = (a.subs(MODEL_2_STATES) for a in accelerations)
    return pulleys, k_m / (J2 + J12) * (motor - pulleys)


def state_form_3(accelerations):
    """x2' and x4bar' of (6.46), beta = 2 k r^2 / J2."""
    drive, load = (a.subs(MODEL_3_STATES) for a in accelerations)
    return load, kk / J2 * (drive - load)


def state_form_4(accelerations):
    """x2', x4bar' and x6bar' of (6.57), beta = 2 k r^2 / J2."""
    motor, drive, load = (a.subs(MODEL_4_STATES) for a in accelerations)
    return load, kk / J2 * (drive - load), kk / J2 * (motor - drive)


def printed_6_39():
    beta = k_m / (J2 + J12)
    x3bar = beta * x3
    return x3bar, beta / J11 * (net - b_1 * (x2 + x4) - (J11 + k_m / beta) * x3bar)


def printed_6_47():
    """With x4bar' on the left of (6.47d)."""
    beta = kk / J2
    x3bar = beta * x3
    return x3bar, beta / J1 * (net - (J2 + J1) * x3bar - b_1 * (x4 + x2))


def printed_6_58():
    beta = kk / J2
    x3bar, x5bar = beta * x3, beta * x5
    joint = J2 / J12 * x3bar - k_m / (beta * J12) * x5bar
    motor = net - b_1 * (x2 + x4 + x6) - k_m / beta * x5bar + J11 * joint
    return x3bar, -kk * (1 / J12 + 1 / J2) * x3bar + k_m / J12 * x5bar, beta / J11 * motor


def test_eq_6_39_states_model_2_without_joint_damping():
    """`confirmed-6-39-6-45`: here the state form."""
    for true, printed in zip(state_form_2(model_2(b_m=0)), printed_6_39(), strict=True):
        assert is_zero(true - printed)


def test_eq_6_58_states_model_4_without_damping():
    """`confirmed-6-57-6-65`: here the state form."""
    for true, printed in zip(state_form_4(model_4(b_m=0, b_c=0)), printed_6_58(), strict=True):
        assert is_zero(true - printed)


def test_eq_6_47d_holds_for_the_scaled_state_only():
    """`erratum-6-47d`: the right-hand side is (p2 / beta) x4bar', beta times (p2 / beta) x4'."""
    x2_rate, x4bar_rate = state_form_3(model_3(b_c=0))
    beta = kk / J2
    right_hand_side = net - (J2 + J1) * beta * x3 - b_1 * (x4 + x2)

    assert is_zero(x2_rate - beta * x3)
    assert is_zero(J1 / beta * x4bar_rate - right_hand_side)
    assert not is_zero(J1 / beta * (x4bar_rate / beta) - right_hand_side)


def test_state_forms_drop_the_joint_and_cable_damping():
    """`erratum-6-39-damping`: what (6.39), (6.47), (6.58) lack of (6.10), (6.11), (6.13) is b_m and b_c."""
    lost_2 = [true - printed for true, printed in zip(state_form_2(model_2()), printed_6_39(), strict=True)]
    pulleys = b_m * x4 / (J2 + J12)
    assert is_zero(lost_2[0] - pulleys)
    assert is_zero(lost_2[1] - k_m / (J2 + J12) * (-b_m * x4 / J11 - pulleys))

    lost_3 = [true - printed for true, printed in zip(state_form_3(model_3()), printed_6_47(), strict=True)]
    load = bb * x4 / J2
    assert is_zero(lost_3[0] - load)
    assert is_zero(lost_3[1] - kk / J2 * (-bb * x4 / J1 - load))

    lost_4 = [true - printed for true, printed in zip(state_form_4(model_4()), printed_6_58(), strict=True)]
    drive = (b_m * x6 - bb * x4) / J12
    assert is_zero(lost_4[0] - load)
    assert is_zero(lost_4[1] - kk / J2 * (drive - load))
    assert is_zero(lost_4[2] - kk / J2 * (-b_m * x6 / J11 - drive))

    load_over_drive = transfer(model_3(), [th1, th2], [om1, om2])
    ratio = sp.cancel(load_over_drive[1] / load_over_drive[0])
    assert sp.cancel(sp.numer(ratio).subs(s, -kk / bb)) == 0, "b_c gives theta_2/theta_1 a zero at -kk/bb"


def test_backstepping_plant_6_66_is_model_3_not_model_1():
    """`erratum-6-7-title`: (6.66), (6.67) are (6.11) without b_c, with a load disturbance: two inertias."""
    d_2 = sp.Symbol("d_2")
    drive = (net - 2 * k * r * (r * th1 - r * th2) - b_1 * om1) / J1
    load = (2 * k * r * (r * th1 - r * th2) + d_2) / J2
    drive_3, load_3 = model_3(b_c=0)
    assert is_zero(drive - drive_3)
    assert is_zero(load.subs(d_2, 0) - load_3)

    rigid = {th2: th1, om2: om1}  # Model 1 is what remains when the cable is rigid: the sum of both equations
    together = (J1 * drive_3 + J2 * load_3).subs(rigid) / (J1 + J2)
    assert is_zero(together - (net - b_1 * om1) / (J1 + J2))
    assert not is_zero(drive - together)
