"""From the fields of a page to the arguments of a command of the package; nothing else runs."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from cabledrive.identification.printer import belt_of, is_printer_file
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studio.library import slug
from cabledrive.studio.state import Desk, State, arguments, drive_of

Form = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Asked:
    """A command to be run: what it is called on the page, and its arguments."""

    title: str
    arguments: list[str]


def drive_file(desk: Desk, state: State, folder: Path) -> str:
    """The drive of a state as a file beside its specification."""
    from cabledrive.parameters import drive_text

    (folder / "drive.toml").write_text(drive_text(drive_of(desk.library, state)), encoding="utf-8")
    return "drive.toml"


def map_option(desk: Desk, state: State) -> list[str]:
    """The map of a cable round two pulleys as an option; a machine with routes has none."""
    try:
        routes = isinstance(drive_of(desk.library, state), RoutedDrive)
    except (InputRefused, NotComputed):
        routes = False
    return [] if routes else ["--map", "map.html"]


def given(form: Form, **options: str) -> list[str]:
    """Options whose field is filled, each with its value in one argument."""
    return [f"{option}={form[name]}" for name, option in options.items() if form.get(name)]


def number(text: str, words: str) -> float:
    """A number from a field, between 0 and 1e9. Raises `InputRefused` with the field's words."""
    try:
        value = float(text)
    except ValueError:
        raise InputRefused(f"{words}: {text[:40]!r} is no number: write one") from None
    if not 0.0 <= value < 1e9:
        raise InputRefused(f"{words} = {value:g} must lie between 0 and 1e9")
    return value


def whole(text: str, words: str, most: int) -> int:
    """A whole number from a field, from 1 to ``most``. Raises `InputRefused` with the field's words."""
    if not (text.isascii() and text.isdigit() and 1 <= int(text[:9]) <= most):
        raise InputRefused(f"{words}: {text[:40]!r} is no whole number from 1 to {most}: write one")
    return int(text)


def travel(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """Natural frequencies over the travel, with the speeds that excite them."""
    options = given(form, vary1="--vary", vary2="--vary", order1="--order", order2="--order", speed="--speed")
    options += given(form, count="--count", motor="--motor")
    if not any(option.startswith("--vary") for option in options):
        raise InputRefused("write what varies, such as head.x=60mm:360mm:3")
    return Asked(
        f"Map of {state.drive} over its travel",
        arguments(desk.library, state, "map", *options, "--page=map.html", "-o", "map.nc"),
    )


def sheet(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """The report of the machine."""
    return Asked(f"Report of {state.drive}", ["report", drive_file(desk, state, folder), "-o", "report.html"])


def virtual_log(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """A log of the virtual rig."""
    options = given(form, axis="--axis", seed="--seed")
    return Asked(
        f"Virtual log of {state.drive}",
        arguments(desk.library, state, "experiment", *options, "-o", "log.csv"),
    )


def ping(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """Tension from the recording of a pluck; a second recording is compared with it."""
    recordings = [desk.logs.path(form.get("log", ""))]
    options = given(form, span="--span")
    if form.get("log2"):
        recordings.append(desk.logs.path(form["log2"]))
        options += given(form, span2="--span")
    source = drive_file(desk, state, folder)
    return Asked(
        f"Tension from {' and '.join(path.name for path in recordings)}",
        ["identify", f"--ping={source}", *options, *(str(path.absolute()) for path in recordings)],
    )


def shaper(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """The page of the printer from all logs here that are named after its tests; of another name, a plot."""
    path = desk.logs.path(form.get("log", ""))
    options = given(form, axis="--axis")
    if options or not is_printer_file(path.name):
        return Asked(
            f"Input shaper from {path.name}", ["shaper", *options, "--plot=shaper.svg", str(path.absolute())]
        )
    oldest_first = [desk.logs.path(log) for log, _ in reversed(desk.logs.listed())]
    paths = {one.name: one.absolute() for one in oldest_first if is_printer_file(one.name)}
    alone = len({belt_of(name) for name in paths} - {None}) == 1
    files = [str(one) for name, one in paths.items() if not (alone and belt_of(name))]
    machine = []
    if isinstance(drive_of(desk.library, state), RoutedDrive):
        machine = [f"--machine={drive_file(desk, state, folder)}"]
    return Asked(f"Printer page of {len(files)} logs", ["shaper", "--page=printer.html", *machine, *files])


def klipper(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """The lines of a printer's configuration from a shaper that was found here."""
    job = desk.jobs.all.get(int(form["job"]) if form.get("job", "").isdecimal() else -1)
    if job is None or job.arguments[0] != "shaper" or not job.answer:
        raise InputRefused("no input shaper was found under this number: find one under Logs first")
    (folder / "shaper.json").write_text(json.dumps(job.answer), encoding="utf-8")
    return Asked(
        f"Printer lines of work {job.number}", ["export", "shaper.json", "--format=klipper", "-o", "klipper"]
    )


LONGEST = 200
FORMATS = ("c99", "fmu2", "fmu3", "mjcf", "modelica")
SWITCHES = {
    "load_friction": ("load friction", "load_coulomb", "N m"),
    "backlash": ("backlash", "backlash", "deg"),
    "cogging": ("cogging", "cogging", "N m"),
    "delay": ("added delay", "added_delay", "ms"),
    "jitter": ("jitter", "jitter", "ms"),
    "shock": ("shock on the load", "shock_torque", "N m"),
}
"""Disturbances of a comparison: words, key of its file, unit."""


DISTURBANCES = {
    "kick": ("torque on the load, 0.05 N m from 0.3 s to 0.6 s", "--disturbance=load:0.05 N m:0.3 s:0.6 s"),
    "dropout": ("load encoder dropout, 20 ms", "--blind=load:0.3 s:0.32 s"),
    "jitter": ("jitter of the sample times, 20 us", "--jitter=20 us"),
    "smooth": ("smooth friction instead of stick-slip", "--smooth-friction"),
    "ideal": ("ideal sensors", "--ideal-sensors"),
}
"""Disturbances of one run: words, option of `track`."""


def asked(desk: Desk, kind: str, state: State, form: Form, folder: Path) -> Asked:
    """The command that a page asks for, its files written into a folder; anything else is refused."""
    if kind not in KINDS:
        raise InputRefused(f'"{kind[:40]}" is nothing that is started here')
    if any(len(value) > LONGEST for value in form.values()):
        raise InputRefused(f"a field holds more than {LONGEST} characters: write less")
    return KINDS[kind](desk, state, form, folder)


def _study(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    options = ["--quick"] if form.get("quick") else []
    options += [f"--log={desk.logs.path(form['log']).absolute()}"] if form.get("log") else []
    if form.get("error"):
        (folder / "goals.toml").write_text(
            f"[goals]\nerror = {json.dumps(form['error'])}\n", encoding="utf-8"
        )
        options.append("--goals=goals.toml")
    return Asked(f"Study of {state.drive}", arguments(desk.library, state, "study", *options, "-o", "study"))


def _compare(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    from cabledrive.rig.laws.registry import CONTROLLERS

    laws = [name for name in CONTROLLERS if form.get(f"law-{name}")]
    options = [f"--controllers={','.join(laws)}"] if laws else []
    options += given(form, axis="--axis", draws="--draws", angle="--angle", rise="--rise", goal="--goal")
    lines = []
    for switch, (words, key, unit) in SWITCHES.items():
        if form.get(switch):
            value = number(form.get(f"{switch}-value", ""), words)
            lines.append(f'{key} = ["0 {unit}", "{value:.9g} {unit}"]')
    if lines:
        (folder / "disturbances.toml").write_text(
            "[disturbances]\n" + "\n".join(lines) + "\n", encoding="utf-8"
        )
        options.append("--disturbances=disturbances.toml")
    return Asked(
        f"Laws compared on {state.drive}",
        arguments(desk.library, state, "compare", *options, "-o", "comparison"),
    )


def _sweep(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    rows, count = whole(form.get("rows", ""), "rows", 10_000), whole(form.get("count", "6"), "modes", 60)
    spec = ["drive = " + json.dumps(drive_file(desk, state, folder)), "", "[vary]"]
    for n in ("1", "2", "3"):
        if form.get(f"key{n}"):
            low, high = (json.dumps(form.get(f"{end}{n}", "")) for end in ("from", "to"))
            spec.append(f"{json.dumps(form[f'key{n}'])} = {{ from = {low}, to = {high} }}")
    spec += ["", "[design]", 'kind = "sobol"', f"rows = {rows}", "seed = 0"]
    spec += ["", "[compute]", 'what = "modes"', f"count = {count}", ""]
    (folder / "campaign.toml").write_text("\n".join(spec), encoding="utf-8")
    return Asked(f"Sweep of {state.drive}", ["sweep", "campaign.toml", "--workers=1", "-o", "campaign.zarr"])


def _export(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    form_ = form.get("format", "")
    if form_ not in FORMATS:
        raise InputRefused(f"format is none of {', '.join(FORMATS)}")
    what = form.get("what", "controller")
    options = [
        f"--format={form_}",
        f"--what={what if what in ('controller', 'plant', 'loop') else 'controller'}",
    ]
    options += given(form, controller="--controller", axis="--axis") + (
        ["--float32"] if form.get("float32") else []
    )
    source = drive_file(desk, state, folder)
    return Asked(
        f"Export of {state.drive} as {form_}", ["export", source, *options, "-o", f"export-{slug(form_)}"]
    )


def _map(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    options = given(form, torque="--torque", limit="--limit")
    if form.get("motion"):
        options.append(f"--motion={desk.logs.path(form['motion']).absolute()}")
    else:
        options = given(form, torque="--torque")
    return Asked(
        f"Resonance map of {state.drive}",
        arguments(desk.library, state, "resonance", *options, *map_option(desk, state)),
    )


def _controlled(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    from cabledrive.rig.laws.registry import CONTROLLERS

    law = form.get("film-law", "")
    if law not in CONTROLLERS:
        raise InputRefused("choose a law for the film")
    options = [f"--controller={law}", *given(form, bandwidth="--bandwidth", angle="--angle")]
    options += [*given(form, rise="--rise", dwell="--dwell"), "--plant=cable", *disturbed(form)]
    return Asked(
        f"Film of {law} on the cable of {state.drive}",
        arguments(desk.library, state, "track", *options, "--animate=film.html", "-o", "track.json"),
    )


def disturbed(given: Form) -> list[str]:
    """Options of `track` for the disturbances that are switched on."""
    return [option for name, (_, option) in DISTURBANCES.items() if given.get(name)]


def _film(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    options = given(form, torque="--torque-amplitude", frequency="--torque-frequency", pluck="--pluck-upper")
    options += [f"--duration={form.get('duration') or '0.5 s'}", "--fields=1", "--animate=film.html"]
    return Asked(
        f"Film of {state.drive}", arguments(desk.library, state, "simulate", *options, "-o", "run.nc")
    )


def _identify(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    path = desk.logs.path(form.get("log", ""))
    options = given(form, model="--model", method="--method") + _columns(form)
    return Asked(
        f"Identification from {path.name}", ["identify", *options, "--report=page.html", str(path.absolute())]
    )


def _response(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    path = desk.logs.path(form.get("log", ""))
    options = given(form, input="--input", response="--response") + _columns(form)
    return Asked(f"Response of {path.name}", ["response", *options, str(path.absolute())])


def _columns(form: Form) -> list[str]:
    """Columns chosen by hand, and whether uneven samples may be moved."""
    chosen = [f"--column={form[f'column{k}']}" for k in range(6) if form.get(f"column{k}")]
    return chosen + (["--resample"] if form.get("resample") else [])


KINDS: dict[str, Callable[[Desk, State, Form, Path], Asked]] = {
    "study": _study,
    "compare": _compare,
    "sweep": _sweep,
    "export": _export,
    "map": _map,
    "film": _film,
    "controlled": _controlled,
    "identify": _identify,
    "response": _response,
    "ping": ping,
    "shaper": shaper,
    "klipper": klipper,
    "travel": travel,
    "sheet": sheet,
    "virtual-log": virtual_log,
}
