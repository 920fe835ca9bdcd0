"""Hypothesis strategies: any drive that the drive file can describe, by the bounds of its fields."""

from dataclasses import fields

from hypothesis import strategies as st

from cabledrive.parameters import Cable, Carriage, Drive, Goal, Layout, Lumped, Motor, Pulley, Sensors

positive = st.floats(1e-12, 1e12)
within = {"positive": positive, "nonnegative": st.just(0.0) | positive, "finite": st.floats(-1e6, 1e6)}
words = st.text(st.characters(blacklist_categories=("Cc", "Cs"), whitelist_characters="\n\t"), max_size=40)


def maybe(strategy):
    """The value, or None: not stated."""
    return st.none() | strategy


def table(kind, **own):
    """A table of the file; ``own``: strategies of fields that others bind."""
    found = {}
    for field in fields(kind):
        if "unit" in field.metadata and field.name not in own:
            count = field.metadata["unit"] == "count"
            one = st.integers(1, 10_000_000) if count else within[field.metadata["bound"]]
            found[field.name] = maybe(one) if field.default is None else one
    return st.builds(kind, **found | own)


materials = st.one_of(
    st.fixed_dictionaries({"youngs_modulus": st.floats(1e6, 1e12), "area": st.floats(1e-9, 1e-2)}),
    st.fixed_dictionaries({"given_rigidity": st.floats(1e-3, 1e10)}),
)
cables = st.builds(
    lambda material, **others: Cable(**material, **others),
    material=materials,
    mass_per_length=st.floats(1e-6, 1e3),
    pretension=st.floats(1e-3, 1e6),
    transverse_damping=within["nonnegative"],
    axial_damping=within["nonnegative"],
    strain_limit=maybe(positive),
)
pulleys, motors, sensors, lumped = (table(kind) for kind in (Pulley, Motor, Sensors, Lumped))


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
        goal=draw(maybe(table(Goal))),
    )
