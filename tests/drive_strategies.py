"""Hypothesis strategies: any drive that the drive file can describe."""

from hypothesis import strategies as st

from cabledrive.parameters import Cable, Carriage, Drive, Goal, Layout, Lumped, Motor, Pulley, Sensors

positive = st.floats(1e-12, 1e12)
nonnegative = st.one_of(st.just(0.0), positive)
counts = st.integers(1, 10_000_000)
words = st.text(st.characters(blacklist_categories=("Cc", "Cs"), whitelist_characters="\n\t"), max_size=40)


def maybe(strategy):
    """The value, or None: not stated."""
    return st.none() | strategy


materials = st.one_of(
    st.fixed_dictionaries({"youngs_modulus": st.floats(1e6, 1e12), "area": st.floats(1e-9, 1e-2)}),
    st.fixed_dictionaries({"given_rigidity": st.floats(1e-3, 1e10)}),
)
cables = st.builds(
    lambda material, **others: Cable(**material, **others),
    material=materials,
    mass_per_length=st.floats(1e-6, 1e3),
    pretension=st.floats(1e-3, 1e6),
    transverse_damping=nonnegative,
    axial_damping=nonnegative,
    strain_limit=maybe(positive),
)
pulleys = st.builds(
    Pulley,
    radius=positive,
    inertia=positive,
    viscous_friction=nonnegative,
    coulomb_friction=nonnegative,
    wrap_angle=maybe(positive),
    capstan_friction=maybe(positive),
)
motors = st.builds(
    Motor,
    inertia=positive,
    viscous_friction=nonnegative,
    coulomb_friction=nonnegative,
    offset_torque=st.floats(-1e6, 1e6),
    joint_stiffness=maybe(positive),
    joint_damping=nonnegative,
    holding_stiffness=maybe(positive),
    torque_limit=maybe(positive),
    torque_per_volt=maybe(positive),
    speed_limit=maybe(positive),
    gear_ratio=maybe(positive),
    rotor_inertia=maybe(positive),
    backlash=nonnegative,
    current_bandwidth=maybe(positive),
)
sensors = st.builds(
    Sensors,
    motor_encoder=maybe(counts),
    drive_encoder=maybe(counts),
    load_encoder=maybe(counts),
    load_cell_noise=maybe(nonnegative),
    sample_rate=maybe(positive),
    delay=nonnegative,
)
lumped = st.builds(Lumped, cable_stiffness=maybe(positive), cable_damping=maybe(nonnegative))


@st.composite
def layouts(draw):
    """A span between 1 mm and 10 km, given by one of its two lengths."""
    key = draw(st.sampled_from(["span_length", "pulley_distance"]))
    length = draw(st.floats(1e-3, 1e4))
    return Layout(
        **{key: length}, gravity=draw(st.floats(0.0, 100.0)), inclination=draw(st.floats(-1.57, 1.57))
    )


@st.composite
def drives(draw, most_carriages=4):
    """Any drive: loop or line, with or without motor, joint, carriages, sensors."""
    cable, layout = draw(cables), draw(layouts())
    kind = draw(st.sampled_from(["loop", "line"]))
    motor = draw(maybe(motors))
    length = layout.span_length or layout.pulley_distance / (1.0 + cable.prestrain)
    places = draw(st.lists(st.floats(0.001, 0.999), max_size=most_carriages, unique=True))
    carriages = [
        Carriage(
            mass=draw(positive),
            position=place * length,
            span=draw(st.sampled_from(["upper", "lower"])) if kind == "loop" else "upper",
            guided=draw(st.booleans()),
        )
        for place in places
    ]
    return Drive(
        name=draw(words),
        title=draw(words),
        source=draw(words),
        kind=kind,
        cable=cable,
        layout=layout,
        pulley=(draw(pulleys), draw(pulleys)),
        carriage=carriages,
        motor=motor,
        lumped=draw(maybe(lumped)),
        sensors=draw(maybe(sensors)),
        goal=draw(maybe(st.builds(Goal, tracking_error=maybe(positive)))),
    )
