"""From the fields of a page to the arguments of a command of the package; nothing of a page is an option."""

import json
from collections.abc import Callable
from pathlib import Path

from cabledrive.parameters import InputRefused
from cabledrive.studio.asked import Asked, Form, drive_file, given, map_option, number, whole
from cabledrive.studio.desk import Desk
from cabledrive.studio.library import slug
from cabledrive.studio.route_commands import klipper, ping, shaper, sheet, travel, virtual_log
from cabledrive.studio.state import State, arguments

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
