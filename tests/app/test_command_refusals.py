"""What the commands refuse: a row names the input, the key in the one line, and the bound or remedy in it.

Every refusal is status 2, one line, at once, and leaves the folder as it was.
"""

import os
import shlex
from pathlib import Path
from time import monotonic

import pytest
from click import Context

from cabledrive.app.combinations import OptionOf
from cabledrive.app.main import main
from command import call, refusal, run, write_log
from study_drives import FOLDER

FILES = {
    "narrow.toml": "[identify]\nbandwidth = 1e-9\n",
    "fading.toml": '[identify]\nmodel = "rigid-axis-stribeck"\nfading = 1e-300\n',
    "late.toml": "[log]\nstart = 1e300\n",
    "long.csv": "time [s],torque [N m]\n0,0\n1e300,1\n",
    "short.csv": "time [s],torque [N m]\n0,0\n1e-300,0.001\n",
    "volts.csv": "time [s],torque [V]\n0,0\n1,1\n",
    "twice.csv": "time [s],torque [N m],Torque [N m]\n0,1,2\n1,1,2\n",
    "speed.csv": "time [s],speed [rad/s]\n" + "".join(f"{0.001 * k},{k % 7}\n" for k in range(300)),
    "places.csv": "time [s],head.x [m]\n" + "".join(f"{0.01 * k},{0.15 + 1e-3 * k}\n" for k in range(40)),
    "many.toml": 'kind = "idinput"\ntrials = 1000000000\n',
    "slow.toml": 'kind = "multisine"\nperiod = 1e300\n',
    "quick.toml": 'kind = "steps"\nperiod = 1e-300\n',
    "point.toml": 'kind = "chirp"\nband = [3, 3]\n',
    "high.toml": "frequencies = [1e300]\namplitudes = [0.1]\n",
    "hours.toml": "[motion]\npulses = 3000\n",
    "other.toml": "[cable]\n",
    "report.html": "mine",
    "shock.toml": 'shock_torque = "0.1 N m"\nshock_time = ["1 s", "4.2 s"]\n',
    "results.json": "{}",
}
D2, D3, MAP = "dissertation-2", "dissertation-3", "map corexy --vary"
RESPONSE, RUN = "response log.csv --input torque --response", f"simulate {D2} --duration"
WINCH = f"study {FOLDER / 'winch.toml'} -o out"
ROWS = {
    "words that are no command or option": [
        ("modes elevator --belwo 3", '"--below"'),
        ("modes elevator --below", "'--below'"),
        ('"mo\ndes"', '"mo\\ndes"'),
        (
            "check elevater",
            'elevater: no such file, and no packaged drive of that name (did you mean "elevator"',
        ),
        ('check ""', '"": no drive is named'),
    ],
    "settings and quantities": [
        ('modes elevator --below "50 rad/s"', "--below", "not Hz"),
        ("modes elevator --below 5 --count 3", "both"),
        ("modes corexy --hold heat", "did you mean"),
        (f"resonance {D2} --torque=-1", "torque"),
        ("resonance serpentine --set route.belt.speed=5", "speed"),
        (f"resonance {D2} --torque 1e300", "1e+24 N m"),
        ("resonance camera-line --load-torque 1e15", "straight cable"),
        (f"resonance {D2} --load-torque 1e15", "elastic range", "N m"),
        ("simulate lift-2-to-1 --duration 1s --travel --animate a.html", "--animate", "--plot"),
        (f'resonance {D2} --load-torque "0.5 N m"', "tension"),
    ],
    "maps and comparisons": [
        (f"{MAP} head.x=60mm", "KEY=FROM:TO"),
        (f"{MAP} head.z=1:2", "head.z"),
        (f'{MAP} "head.x=60 kg:70 kg"', "dimension"),
        (f"{MAP} head.x=60mm:360mm --order 'a=motor a'", "--speed"),
        (f"{MAP} head.x=60mm:360mm --margin 0.1", "--order"),
        (f"{MAP} head.x=60mm:360mm:99999 --vary beam.y=1:2", "number of values"),
        (f"compare {D3} --controllers lqi,nobody -o out", "nobody"),
        (f"compare {D3} --controllers lqi,lqi -o out", "lqi", "twice"),
        (f"compare {D3} --controllers ' , ' -o out", "controllers", "none"),
        (f"compare {D3} --draws 0 -o out", "draws = 0", "1"),
        (f"compare {D3} --goal -1 -o out", "goal = -1", "above 0"),
        (f"compare {D3} --disturbances absent.toml -o out", "absent.toml"),
        (f"compare {D3} --disturbances shock.toml -o out", "shock_time up to 4.2 s", "ends at 4 s"),
    ],
    "logs": [
        ("identify log.csv --config narrow.toml", "bandwidth = 1e-09 Hz", "1.999 s"),
        ("identify log.csv --config fading.toml", "identify.fading = 1e-300 rad/s"),
        ("identify log.csv --config late.toml", "1e+300 s", "1.999 s"),
        ("identify log.csv --column torque=torque:mN*1e400", '"1e400"', "finite"),
        ("identify log.csv --model=", 'model ""'),
        ("identify log.csv --method=", 'method ""'),
        ("identify log.csv --span upper", "--span", "--ping DRIVE"),
        ("identify log.csv --section 0", "--section", "--ping DRIVE"),
        ("identify log.csv --ping elevator --no-check", "--no-check", "axis"),
        ("identify log.csv --ping elevator --report p.html", "--report", "axis"),
        ("identify log.csv -o i.csv", ".json"),
        (f"{RESPONSE} angle --segment=-1", "segment = -1 s", "above 0"),
        (f"{RESPONSE} angle --overlap 1e300", "overlap = 1e+300 s"),
        (f"{RESPONSE} angle --coulomb=-1", "--coulomb = -1 N m"),
        (f"{RESPONSE} angle --offset 1", "--offset", "--coulomb"),
        (f"{RESPONSE} torque", '"torque"', "time, torque, angle"),
        ('response log.csv --input torque --response "torque [N m]"', '"torque"', "time, torque, angle"),
        ("response printer-idlers --response tail", '"tail"', "head.x"),
        ("response corexy --below 1e9", "1e+09 Hz", "lower it"),
        ("camera a.avi -o c.csv --scale 0", "scale = 0 m"),
        ("camera a.avi --scale 1mm --known-pixels 3 -o a.csv", "--known-pixels", "--scale"),
    ],
    "motions and excitations": [
        (f"resonance {D2} --motion long.csv", "1e+300 s"),
        (f"resonance {D2} --motion short.csv", "1e-300 s", "1 steps"),
        (f"resonance {D2} --motion volts.csv", "torque"),
        (f"resonance {D2} --motion twice.csv", "two columns have one name"),
        (f"resonance {D2} --limit 1mm", "--limit", "--motion FILE"),
        (f"resonance {D2} --map report.html", "report.html: exists"),
        ("check corexy --motion places.csv", "add beam.y"),
        (f"experiment {D3} --excitation many.toml -o a.csv", "trials = 1000000000", "1000000"),
        (f"experiment {D3} --excitation slow.toml -o a.csv", "period = 1e+300 s", "4571 s"),
        (f"experiment {D3} --excitation quick.toml -o a.csv", "2 or more"),
        (f"experiment {D3} --excitation point.toml -o a.csv", "band", "3 Hz"),
        (f"experiment {D3} --excitation high.toml -o a.csv", "1e+300 Hz"),
        (f"experiment {D3} --set sensors.sample_rate=1e20 -o a.csv", "1e+20 Hz", "GB"),
        (f"experiment {D3} --stroke 1 -o a.csv", "--stroke", "--plan"),
        (f"experiment {D3} --plan -o a.csv", "--output", "--plan"),
    ],
    "simulations": [
        (f"{RUN} 0", "duration = 0.0 s", "above 0"),
        (f"{RUN} inf", "not a quantity"),
        (f"{RUN} 1 --step '1 ms'", "at most 3.32"),
        (f"{RUN} 1 --segments 2", "at least 3"),
        (f"{RUN} 1 --segments 1000000", "at most 5e+07"),
        (f"{RUN} 1 --segments 9 --model fast", "--model fast"),
        (f"{RUN} 1 --fields 2", "--fields", "RUN.nc"),
        (f"{RUN} 1 --pluck-upper '2 m'", "longer than the span"),
        (f"{RUN} 1 --pluck-upper '2 s'", "[time]"),
        (f"{RUN} 1 --torque-frequency 1", "--torque-amplitude"),
        (f"{RUN} 1 --torque-amplitude 1 --torque-frequency -5", "must not be negative"),
        (f"{RUN} 1 --model fast --torque-amplitude 1 --torque-frequency 1e9", "two"),
        (f"{RUN} 1 --model fast --animate x.html", "--animate"),
        (f"{RUN} 1 --model cubic", "'cubic'"),
        (f"{RUN} 1 --resume", "resume", "output"),
        (f"{RUN} 5e5 --rate '1 MHz' -o run.nc", "are free in ."),
        (f"{RUN} '1 ms' --rate 1 --plot run.png", "16 records"),
        (f"{RUN} '10 ms' --fields 1000 --animate run.html", "two pictures"),
        *[
            (f"simulate {machine} --duration '1 ms' {option}", word)
            for machine, option, word in (
                ("printer-idlers", "--pluck-upper '1 mm'", '"upper" is no span: take one of left clamp'),
                (
                    "printer-idlers",
                    "--model fast",
                    "exact, takes one cable between two pulleys",
                ),
                ("camera-winches", "--travel --fields 2 -o run.nc", "fields"),
                ("printer-idlers", "--pluck '1 mm'", "SPAN=HEIGHT"),
                (D2, "--pluck 'left=1 mm'", "take one of upper; lower"),
                (D2, "--torque-on motor", "the motors are drive pulley"),
            )
        ],
    ],
    "tracking": [
        (f"track {D3} --angle nan", '"nan"'),
        (f"track {D3} --angle 300 --rise 0.3 --order 9", "2.402 N m"),
        (f"track {D3} --seed -1", "seed = -1"),
        (f"track {D3} --plant cable --jitter 1e-5", "cable"),
        (f"track {D3} --plant cable --segments 1000000", "segments = 1000000", "39"),
        (f"track {D3} --segments 9", "--segments", "plant"),
        (f"track {D3} --controller pid --no-adaptation", "--no-adaptation", "pid"),
        (f"track {D3} --blind gear:0.1:0.2", "SHAFT:START:END"),
        (f"track {D3} --disturbance drive:0.1:0.2", "motor or load"),
        (f"track {D3} --disturbance load:0.1:3:4", "3 s", "2 s"),
        (f"track {D3} --jitter '1 ms'", "jitter = 0.001 s", "0.4"),
        (f"track {D3} --pulses 1000000000", "pulses = 1000000000", "10000"),
        (f"track {D3} --draws 1000000000", "draws = 1000000000", "100000"),
        (f"track {D3} --set sensors.delay=1e20", "sensors.delay = 1e+20 s", "2 s"),
        (f"track {D3} --set 'sensors.sample_rate=10 MHz'", "2e+07 samples"),
        (f"track {D3} --controller best --bandwidth 9", "tuned as a whole"),
        (f"track {D3} --pair", "motor.backlash is 0"),
        (f"track {D3} --gust '3 N'", "two winches"),
        ("track camera-winches --controller lqg", "leave it out"),
        ("track camera-winches --move camera.x", "NAME=DISTANCE"),
        ("track camera-winches --disturbance load:1:2", "camera.x, camera.y"),
        ("track camera-winches --pair", "two winches"),
        ("track camera-winches --least-tension '900 N'", "tension at rest"),
    ],
    "studies, pages and exports": [
        (f"{WINCH} --goals other.toml", "other.toml", "unknown"),
        (f"{WINCH} --set 'cable.pretension=-3 N'", "cable.pretension"),
        (f"{WINCH} --quiet --log speed.csv", "speed.csv", "torque [N m]", "velocity"),
        (f"{WINCH.removesuffix('out')}log.csv", "is a file"),
        (f"{WINCH.removesuffix('out')}a/b", "does not exist"),
        (f"{WINCH.removesuffix('out')}.", "no study's"),
        (f"study {D3} --goals hours.toml -o out --quick", "3e+07 samples", "18 GB"),
        (f"study {D3} --output=", "--output"),
        ("report elevator elevater -o page.html", "elevater"),
        ("check elevator -o report.html --force", ".json"),
        ("modes ropeway --plot absent/modes.svg", "does not exist"),
        ("modes ropeway --plot log.csv/modes.svg", "is a file"),
        ("modes ropeway --plot modes.gif", ".png or .svg or .pdf"),
        ("modes elevator --below 1e12 --plot a.svg -o a.json", "at most 20000"),
        ("resonance elevator -o map --map map", "map", "twice"),
        ("drives -o list.toml", "list.toml"),
        ("drives elevatr", "elevator"),
        ("study tendon-finger --quick -o o", "springs or ropes hold", "drum"),
    ],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a log of 2 s at 1 kHz and odd files."""
    place = tmp_path_factory.mktemp("odd")
    write_log(place / "log.csv")
    for name, text in FILES.items():
        (place / name).write_text(text)
    return place


@pytest.mark.parametrize(
    "row",
    [row for rows in ROWS.values() for row in rows],
    ids=lambda row: row[0].replace(str(FOLDER), "drives"),
)
def test_refused_in_one_line_at_once_with_nothing_written(row, folder, monkeypatch):
    monkeypatch.chdir(folder)
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    command, *words = row
    began = monotonic()
    line = refusal(*shlex.split(command)).lower()
    assert monotonic() - began < 60.0, "refused after the work"
    for word in words:
        assert word.lower() in line, line
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before


PIPES = {
    "drive": "check {}",
    "goals": "study dissertation-2 --quick --goals {} -o out",
    "motion": "resonance dissertation-2 --motion {}",
    "log": "identify {}",
    "configuration": "identify log.csv --config {}",
    "excitation": "experiment dissertation-2 --excitation {}",
    "response": "response {} --input torque --response angle",
    "resonance test": "shaper {}",
    "ping": "identify {} --ping dissertation-2 --span upper",
}


@pytest.mark.parametrize("kind", PIPES)
def test_a_pipe_that_nobody_writes_and_a_device_without_end_are_refused_at_once(tmp_path, kind):
    os.mkfifo(tmp_path / "pipe.csv")
    began = monotonic()
    for source in (tmp_path / "pipe.csv", "/dev/zero"):
        line = refusal(*PIPES[kind].format(source).split())
        assert f"{Path(source).name}: is a device or a pipe" in line
    assert monotonic() - began < 5.0


def test_a_name_that_is_no_text_and_a_path_too_long_are_refused(tmp_path):
    named = os.fsdecode(os.fsencode(str(tmp_path)) + b"/\xff\xfe.csv")
    for path in (named, str(tmp_path / ("x" * 5000)), str(tmp_path / "a.csv" / "b.csv")):
        result = call("identify", path)
        assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1), result.stderr
    Path(named).write_text("time,torque\n1,x\n")
    result = run("identify", named)
    assert (result.returncode, result.stderr.count("\n")) == (2, 1), result.stderr


@pytest.mark.parametrize("arguments", [["check"], ["modes", "--count", "1"], ["identify", "--no-check"]])
def test_a_file_that_is_read_is_never_written_over(arguments, tmp_path):
    name, *options = arguments
    path = tmp_path / "mine"
    path.write_text("precious")
    (tmp_path / "link").symlink_to(path)
    for output in (path, tmp_path / "link", tmp_path / "." / "mine"):
        refusal(name, path, *options, "-o", output, "--force")
        assert path.read_text() == "precious"


def _values():
    """A value for each option of `response` that says of which kinds of input it is."""
    given = {"--config": "log.toml", "--column": "torque=tau:N mm", "--estimator": "H2", "--skip-rows": "1"}
    for option in main.get_command(Context(main), "response").params:
        if isinstance(option, OptionOf):
            name = option.opts[0]
            yield name, option.of, [name] if option.is_flag else [name, given.get(name, "1")]


@pytest.mark.parametrize("kind", ["drive", "file"])
def test_response_refuses_every_option_that_its_input_does_not_have(kind, tmp_path):
    """Of ten options for logs none is ignored with a drive file or a measured response."""
    source = "printer-idlers"
    if kind == "file":
        source = tmp_path / "measured.csv"
        source.write_text("frequency [Hz],magnitude,phase [deg]\n1,1,0\n2,0.5,-10\n")
    refused = [name for name, of, words in _values() if kind not in of]
    assert {"--segment", "--coulomb", "--amplifier", "--estimator", "--resample"} <= set(refused)
    for name, of, words in _values():
        if kind not in of:
            assert refusal("response", source, *words).startswith(f"{name} is for "), name
