"""Whatever is done to a valid drive file, it loads or is refused in one line: nothing else ever happens."""

from hypothesis import given, settings
from hypothesis import strategies as st

from cabledrive.parameters import Drive, InputRefused, load_drive
from drive_mutations import FILES, keys, mutants, odd_texts, values


def message_of_refusal(path, **options):
    """Load the file: the refusal's message, or nothing if it is a drive."""
    try:
        assert isinstance(load_drive(path, **options), Drive)
    except InputRefused as refusal:
        return str(refusal)
    return None


def check(content, tmp_path_factory, **options):
    """The claim of this file."""
    path = tmp_path_factory.getbasetemp() / "mutant.toml"
    path.write_bytes(content)
    message = message_of_refusal(path, **options)
    if message is not None:
        assert message.isprintable(), f"{message!r}"
        assert len(message) < 300, f"{len(message)} characters: {message}"
        assert message.startswith(f"{path}: ")


@given(content=mutants())
@settings(max_examples=200)
def test_any_change_of_keys_and_values_loads_or_is_refused(content, tmp_path_factory):
    check(content, tmp_path_factory)


@given(
    content=st.sampled_from(FILES),
    flips=st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), min_size=1, max_size=6),
)
@settings(max_examples=200)
def test_any_flip_of_bytes_loads_or_is_refused(content, flips, tmp_path_factory):
    mutant = bytearray(content)
    for place, byte in flips:
        mutant[place % len(mutant)] = byte
    check(bytes(mutant), tmp_path_factory)


places = st.lists(
    st.sampled_from(["cable", "pulley", "carriage", "0", "1", "pretension", "radius"]) | keys, max_size=4
)
settings_texts = st.builds(
    lambda place, value: f"{'.'.join(place)}={value}",
    places,
    st.one_of(st.text(max_size=20), odd_texts, values.map(str)),
)


@given(overrides=st.lists(settings_texts | st.text(max_size=20), min_size=1, max_size=3))
@settings(max_examples=200)
def test_any_setting_loads_or_is_refused(overrides, tmp_path_factory):
    check(FILES[0], tmp_path_factory, overrides=overrides)
