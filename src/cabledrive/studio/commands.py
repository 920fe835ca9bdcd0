"""From the fields of a page to the arguments of a command of the package; nothing else runs."""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from cabledrive.identification.printer import belt_of, is_printer_file
from cabledrive.parameters import InputRefused, NotComputed, drive_text
from cabledrive.studies.mode_map import coordinates_of
from cabledrive.studio.library import slug
from cabledrive.studio.state import Desk, State, arguments, drive_of

Form = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Asked:
    """A command to be run: what it is called on the page, and its arguments."""

    title: str
    arguments: list[str]


@dataclass(frozen=True, slots=True)
class Asking:
    """What a page asks for, and the folder in which the command will run."""

    desk: Desk
    state: State
    form: Form
    folder: Path

    def given(self, *names: str, **others: str) -> list[str]:
        """Options whose field is filled, each with its value in one argument; others by their fields."""
        options = {name: f"--{name}" for name in names} | others
        return [f"{option}={self.form[name]}" for name, option in options.items() if self.form.get(name)]

    def on_drive(self, title: str, command: str, *options: str) -> Asked:
        """A command on the drive of the state, whose name closes the title."""
        made = arguments(self.desk.library, self.state, command, *options)
        return Asked(f"{title} {self.state.drive}", made)

    def log(self, field: str = "log") -> Path:
        """The log that a field names."""
        return self.desk.logs.path(self.form.get(field, "")).absolute()

    def write(self, name: str, text: str) -> str:
        """A file beside the specification; its name."""
        (self.folder / name).write_text(text, encoding="utf-8")
        return name

    def drive_file(self) -> str:
        """The drive of the state as such a file."""
        return self.write("drive.toml", drive_text(drive_of(self.desk.library, self.state)))


def map_option(desk: Desk, state: State) -> list[str]:
    """The map of a cable round two pulleys as an option; a machine with routes has none."""
    try:
        drive = drive_of(desk.library, state)
    except (InputRefused, NotComputed):
        return ["--map", "map.html"]
    return [] if drive.two_pulleys is None else ["--map", "map.html"]


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
    return KINDS[kind](Asking(desk, state, form, folder))


def _travel(own: Asking) -> Asked:
    """Natural frequencies over the travel, with the speeds that excite them."""
    repeated = {"vary1": "--vary", "vary2": "--vary", "order1": "--order", "order2": "--order"}
    options = [*own.given(**repeated), *own.given("speed", "count", "motor")]
    if not any(option.startswith("--vary") for option in options):
        raise InputRefused("write what varies, such as head.x=60mm:360mm:3")
    found = own.on_drive("Map of", "map", *options, "--page=map.html", "-o", "map.nc")
    return replace(found, title=f"{found.title} over its travel")


def _sheet(own: Asking) -> Asked:
    """The report of the machine."""
    return Asked(f"Report of {own.state.drive}", ["report", own.drive_file(), "-o", "report.html"])


def _virtual_log(own: Asking) -> Asked:
    """A log of the virtual rig."""
    return own.on_drive("Virtual log of", "experiment", *own.given("axis", "seed"), "-o", "log.csv")


def _ping(own: Asking) -> Asked:
    """Tension from the recording of a pluck; a second recording is compared with it."""
    recordings, options = [own.log()], own.given("span")
    if own.form.get("log2"):
        recordings.append(own.log("log2"))
        options += own.given(span2="--span")
    title = f"Tension from {' and '.join(path.name for path in recordings)}"
    return Asked(title, ["identify", f"--ping={own.drive_file()}", *options, *map(str, recordings)])


def _shaper(own: Asking) -> Asked:
    """The page of the printer from all logs here that are named after its tests; of another name, a plot."""
    path, options, logs = own.log(), own.given("axis"), own.desk.logs
    if options or not is_printer_file(path.name):
        return Asked(f"Input shaper from {path.name}", ["shaper", *options, "--plot=shaper.svg", str(path)])
    oldest_first = [logs.path(log) for log, _ in reversed(logs.listed())]
    paths = {one.name: one.absolute() for one in oldest_first if is_printer_file(one.name)}
    alone = len({belt_of(name) for name in paths} - {None}) == 1
    files = [str(one) for name, one in paths.items() if not (alone and belt_of(name))]
    drive = drive_of(own.desk.library, own.state)
    machine = [f"--machine={own.drive_file()}"] if coordinates_of(drive) or drive.carriage else []
    return Asked(f"Printer page of {len(files)} logs", ["shaper", "--page=printer.html", *machine, *files])


def _klipper(own: Asking) -> Asked:
    """The lines of a printer's configuration from a shaper that was found here."""
    number = own.form.get("job", "")
    job = own.desk.jobs.all.get(int(number) if number.isdecimal() else -1)
    if job is None or job.arguments[0] != "shaper" or not job.answer:
        raise InputRefused("no input shaper was found under this number: find one under Logs first")
    source = own.write("shaper.json", json.dumps(job.answer))
    return Asked(
        f"Printer lines of work {job.number}", ["export", source, "--format=klipper", "-o", "klipper"]
    )


def _study(own: Asking) -> Asked:
    options = ["--quick"] if own.form.get("quick") else []
    options += [f"--log={own.log()}"] if own.form.get("log") else []
    if error := own.form.get("error"):
        goals = own.write("goals.toml", f"[goals]\nerror = {json.dumps(error)}\n")
        options.append(f"--goals={goals}")
    return own.on_drive("Study of", "study", *options, "-o", "study")


def _compare(own: Asking) -> Asked:
    laws = [name for name in _laws() if own.form.get(f"law-{name}")]
    options = [f"--controllers={','.join(laws)}"] if laws else []
    options += own.given("axis", "draws", "angle", "rise", "goal")
    lines = []
    for switch, (words, key, unit) in SWITCHES.items():
        if own.form.get(switch):
            value = number(own.form.get(f"{switch}-value", ""), words)
            lines.append(f'{key} = ["0 {unit}", "{value:.9g} {unit}"]\n')
    if lines:
        file = own.write("disturbances.toml", "".join(["[disturbances]\n", *lines]))
        options.append(f"--disturbances={file}")
    return own.on_drive("Laws compared on", "compare", *options, "-o", "comparison")


def _laws() -> Iterable[str]:
    """Names of all control laws, whose libraries no page waits for."""
    from cabledrive.rig.laws.registry import CONTROLLERS

    return CONTROLLERS


def _sweep(own: Asking) -> Asked:
    form = own.form
    rows, count = whole(form.get("rows", ""), "rows", 10_000), whole(form.get("count", "6"), "modes", 60)
    spec = ["drive = " + json.dumps(own.drive_file()), "", "[vary]"]
    for n in ("1", "2", "3"):
        if form.get(f"key{n}"):
            low, high = (json.dumps(form.get(f"{end}{n}", "")) for end in ("from", "to"))
            spec.append(f"{json.dumps(form[f'key{n}'])} = {{ from = {low}, to = {high} }}")
    spec += ["", "[design]", 'kind = "sobol"', f"rows = {rows}", "seed = 0"]
    spec += ["", "[compute]", 'what = "modes"', f"count = {count}", ""]
    file = own.write("campaign.toml", "\n".join(spec))
    return Asked(f"Sweep of {own.state.drive}", ["sweep", file, "--workers=1", "-o", "campaign.zarr"])


def _export(own: Asking) -> Asked:
    form, what = own.form.get("format", ""), own.form.get("what", "controller")
    if form not in FORMATS:
        raise InputRefused(f"format is none of {', '.join(FORMATS)}")
    what = what if what in ("controller", "plant", "loop") else "controller"
    options = [f"--format={form}", f"--what={what}", *own.given("controller", "axis")]
    options += ["--float32"] if own.form.get("float32") else []
    arguments = ["export", own.drive_file(), *options, "-o", f"export-{slug(form)}"]
    return Asked(f"Export of {own.state.drive} as {form}", arguments)


def _map(own: Asking) -> Asked:
    options = own.given("torque")
    if own.form.get("motion"):
        options += [*own.given("limit"), f"--motion={own.log('motion')}"]
    return own.on_drive("Resonance map of", "resonance", *options, *map_option(own.desk, own.state))


def _controlled(own: Asking) -> Asked:
    law = own.form.get("film-law", "")
    if law not in _laws():
        raise InputRefused("choose a law for the film")
    options = [f"--controller={law}", *own.given("bandwidth", "angle", "rise", "dwell"), "--plant=cable"]
    files = ("--animate=film.html", "-o", "track.json")
    return own.on_drive(f"Film of {law} on the cable of", "track", *options, *disturbed(own.form), *files)


def disturbed(given: Form) -> list[str]:
    """Options of `track` for the disturbances that are switched on."""
    return [option for name, (_, option) in DISTURBANCES.items() if given.get(name)]


def _film(own: Asking) -> Asked:
    options = own.given(torque="--torque-amplitude", frequency="--torque-frequency")
    if own.form.get("pluck"):
        span = drive_of(own.desk.library, own.state).spans[0]
        options.append(f"--pluck={span}={own.form['pluck']}")
    options += [f"--duration={own.form.get('duration') or '0.5 s'}", "--fields=1", "--animate=film.html"]
    return own.on_drive("Film of", "simulate", *options, "-o", "run.nc")


def _identify(own: Asking) -> Asked:
    path, options = own.log(), [*own.given("model", "method"), *_columns(own.form)]
    title = f"Identification from {path.name}"
    return Asked(title, ["identify", *options, "--report=page.html", str(path)])


def _response(own: Asking) -> Asked:
    path, options = own.log(), [*own.given("input", "response"), *_columns(own.form)]
    return Asked(f"Response of {path.name}", ["response", *options, str(path)])


def _columns(form: Form) -> list[str]:
    """Columns chosen by hand, and whether uneven samples may be moved."""
    chosen = [f"--column={form[f'column{k}']}" for k in range(6) if form.get(f"column{k}")]
    return chosen + (["--resample"] if form.get("resample") else [])


_BUILDERS = (_study, _compare, _sweep, _export, _map, _film, _controlled, _identify, _response, _ping)
KINDS: dict[str, Callable[[Asking], Asked]] = {
    build.__name__[1:].replace("_", "-"): build
    for build in (*_BUILDERS, _shaper, _klipper, _travel, _sheet, _virtual_log)
}
"""What is started here, by the name that a page gives it."""
