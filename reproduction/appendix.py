"""Tables A.1 to A.3: what of the data sheets follows from the rest of them, and what stands alone."""

from math import pi, sqrt

from cabledrive.parameters import load_drive
from cabledrive.rig.bench.virtual_rig import BENCH_TESTS
from reproduction.item import (
    DIFFERS,
    Entry,
    Item,
    Otherwise,
    Outcome,
    outcome,
    place,
)
from reproduction.judge import compared, erratum, taken, unknown

RPM = 2 * pi / 60
VOLTAGE, RESISTANCE = 24.0, 0.103
TORQUE_CONSTANT, NOMINAL_TORQUE, NOMINAL_SPEED = 38.5e-3, 0.405, 5680.0
NO_LOAD_CURRENT, STARTING_CURRENT, ROTOR = 0.236, 232.0, 536e-7

CONSISTENT = 0.01
"""Rows of a data sheet agree with one another where they are within one per cent."""

ALONE = "a datum of the manufacturer: nothing in the print gives it again"
PRICE = "a price of 2015: nothing in the print gives it again"
SHEET: Otherwise = (
    DIFFERS,
    "the manufacturer's rounding of its own data: the table's other rows give it only so nearly",
)


def table_a_1(quick: bool) -> Outcome:
    """Table A.1, the motor: each row from the others where they determine it.

    ``quick``: changes nothing here.
    """
    constant = TORQUE_CONSTANT
    slope = RESISTANCE / constant**2 / RPM * 1e-3
    free = (VOLTAGE - RESISTANCE * NO_LOAD_CURRENT) / constant / RPM
    rows: list[Item] = [
        unknown("table-a-1-price", "Table A.1: price", "592.38", "USD", PRICE),
        erratum(
            "table-a-1-power",
            "Table A.1: power in the name; Section 4.1 has 240 W",
            200.0,
            NOMINAL_TORQUE * NOMINAL_SPEED * RPM,
            "W",
            "200 W is the name, 240.9 W nominal torque times nominal speed; Section 4.1 prints 240. "
            f"{place('erratum-4-1-motor-power')}",
        ),
        unknown("table-a-1-length", "Table A.1: motor length", 108.0, "mm", ALONE),
        unknown("table-a-1-diameter", "Table A.1: outer diameter", 50.0, "mm", ALONE),
        unknown("table-a-1-voltage", "Table A.1: nominal voltage", 24.0, "V", ALONE),
    ]
    for key, words, printed, value, unit, otherwise in (
        ("no-load-speed", "no load speed, from voltage and constants", "5950.0", free, "rpm", SHEET),
        (
            "nominal-speed",
            "nominal speed, from the speed / torque gradient",
            "5680.0",
            free - slope * 1e3 * NOMINAL_TORQUE,
            "rpm",
            SHEET,
        ),
        (
            "nominal-torque",
            "nominal torque, from nominal and no load current",
            "405.0",
            1e3 * constant * (10.8 - NO_LOAD_CURRENT),
            "mN m",
            SHEET,
        ),
        (
            "stall-torque",
            "stall torque, from the starting current",
            "8920.0",
            1e3 * constant * STARTING_CURRENT,
            "mN m",
            SHEET,
        ),
        ("starting-current", "starting current, V/R", "232.0", VOLTAGE / RESISTANCE, "A", SHEET),
        (
            "efficiency",
            "largest efficiency, (1 - sqrt(I0/IA))^2",
            "93.8",
            100 * (1 - sqrt(NO_LOAD_CURRENT / STARTING_CURRENT)) ** 2,
            "%",
            SHEET,
        ),
        ("gradient", "speed / torque gradient, R/k^2", "0.668", slope, "rpm/(mN m)", SHEET),
        (
            "time-constant",
            "mechanical time constant, J R/k^2",
            "3.75",
            1e3 * ROTOR * RESISTANCE / constant**2,
            "ms",
            SHEET,
        ),
        ("speed-constant", "speed constant, 1/k", "248.0", 1.0 / constant / RPM, "rpm/V", SHEET),
    ):
        rows.append(
            compared(
                f"table-a-1-{key}",
                f"Table A.1: {words}",
                printed,
                value,
                unit,
                tolerance=CONSISTENT * float(printed),
                note="a consistency of the table with itself",
                otherwise=otherwise,
                tested=False,
            )
        )
    for key, words, alone, unit in (
        ("no-load-current", "no load current", 236.0, "mA"),
        ("nominal-current", "nominal current", 10.8, "A"),
        ("inductance", "terminal inductance", 0.072, "mH"),
        ("resistance", "terminal resistance", 0.103, "ohm"),
        ("torque-constant", "torque constant", 38.5, "mN m/A"),
    ):
        rows.append(unknown(f"table-a-1-{key}", f"Table A.1: {words}", alone, unit, ALONE))
    rows.append(
        erratum(
            "table-a-1-rotor",
            "Table A.1: rotor inertia beside J11 = 0.0011 of Table 4.1",
            536.0,
            BENCH_TESTS[0].inertia / gear_ratio() ** 2 * 1e7,
            "g cm^2",
            "J11 of Table 4.1 taken back through the gear; the rotor alone is heavier. "
            f"{place('erratum-table-4-1-reflected-inertia')}",
        )
    )
    return outcome(rows)


def table_a_2(quick: bool) -> Outcome:
    """Table A.2, the motor's encoder.

    ``quick``: changes nothing here.
    """
    return outcome(
        [
            unknown("table-a-2-price", "Table A.2: price", "131.5", "USD", PRICE),
            unknown("table-a-2-channels", "Table A.2: number of channels", 3.0, "", ALONE),
            taken("table-a-2-counts", "Table A.2: counts per turn", "500", encoder_counts(), ""),
            unknown("table-a-2-speed", "Table A.2: largest speed", 12000.0, "rpm", ALONE),
        ]
    )


def encoder_counts() -> float:
    """Counts per turn of the motor itself, by the packaged drive."""
    sensors = load_drive("dissertation-3").sensors
    assert sensors is not None
    assert sensors.motor_encoder is not None
    return sensors.motor_encoder / gear_ratio()


def gear_ratio() -> float:
    """Reduction of the gearhead, by the packaged drive."""
    motor = load_drive("dissertation-3").motor
    assert motor is not None
    assert motor.gear_ratio is not None
    return motor.gear_ratio


def table_a_3(quick: bool) -> Outcome:
    """Table A.3, the gearhead.

    ``quick``: changes nothing here.
    """
    gear = gear_ratio()
    rows = [
        unknown("table-a-3-price", "Table A.3: price", "544", "USD", PRICE),
        taken("table-a-3-reduction", "Table A.3: reduction", "5.2", gear, ""),
        unknown("table-a-3-stages", "Table A.3: number of stages", 1.0, "", ALONE),
        erratum(
            "table-a-3-torque",
            "Table A.3: intermittent torque at the output, beside Section 6.5.1",
            "12.0 N m",
            f"{NOMINAL_TORQUE * gear:.3f} N m is called the maximum achievable value",
            "",
            f"that is the continuous rating of the motor. {place('erratum-4-1-achievable-torque')}",
        ),
        erratum(
            "table-a-3-backlash",
            "Table A.3: average backlash without load",
            "1.0 deg, beside a tracking error of 0.055 deg",
            f"{1.0 / 0.055:.0f} times that error",
            "",
            f"never discussed. {place('erratum-table-a-3-backlash')}",
        ),
        compared(
            "table-a-3-inertia",
            "Table A.3: mass inertia, from J11 + J12 of Table 4.1 less the rotor",
            "109.0",
            (BENCH_TESTS[1].inertia / gear**2 - ROTOR) * 1e7,
            "g cm^2",
            tolerance=CONSISTENT * 109.0,
            note=(
                "perhaps chance: the drive pulley would weigh nothing. "
                f"{place('erratum-table-4-1-reflected-inertia')}"
            ),
            tested=False,
        ),
        erratum(
            "table-a-3-input",
            "Table A.3: recommended input speed, beside Section 4.1",
            "3000.0 rpm",
            f"driven up to {NOMINAL_SPEED:.0f} rpm",
            "",
            f"the print does not mention it. {place('erratum-table-a-3-input-speed')}",
        ),
    ]
    for key, words, alone, unit in (
        ("weight", "weight", 950.0, "g"),
        ("shaft", "largest motor shaft diameter", 8.0, "mm"),
        ("diameter", "outer diameter", 62.0, "mm"),
        ("flange", "measurement from flange", 24.0, "mm"),
    ):
        rows.append(unknown(f"table-a-3-{key}", f"Table A.3: {words}", alone, unit, ALONE))
    return outcome(rows)


ENTRIES = (
    Entry(name="table-a-1", chapter="A", covers=("Table A.1",), compute=table_a_1),
    Entry(name="table-a-2", chapter="A", covers=("Table A.2",), compute=table_a_2),
    Entry(name="table-a-3", chapter="A", covers=("Table A.3",), compute=table_a_3),
)
