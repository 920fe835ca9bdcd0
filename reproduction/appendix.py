"""Tables A.1 to A.3: what of the data sheets follows from the rest of them, and what stands alone."""

from math import pi, sqrt
from string import Template

from cabledrive.parameters import load_drive
from cabledrive.rig.bench.virtual_rig import BENCH_TESTS
from reproduction.items import Outcome

ITSELF = """arithmetic within 1 %
  agrees: a consistency of the table with itself
  differs: the manufacturer's rounding of its own data: the table's other rows give it only so nearly"""
SHEET = Template("""
## table-a-1 table_a_1: Table A.1
table-a-1-price | Table A.1: price | 592.38 | USD | price
table-a-1-power | Table A.1: power in the name; Section 4.1 has 240 W | 200 | W | arithmetic
  erratum: 200 W is the name, 240.9 W nominal torque times nominal speed; Section 4.1 prints 240.
    #erratum-4-1-motor-power
table-a-1-length | Table A.1: motor length | 108.0 | mm | datum
table-a-1-diameter | Table A.1: outer diameter | 50.0 | mm | datum
table-a-1-voltage | Table A.1: nominal voltage | 24.0 | V | datum
table-a-1-no-load-speed | Table A.1: no load speed, from voltage and constants | 5950.0 | rpm | $itself
table-a-1-nominal-speed | Table A.1: nominal speed, from the speed / torque gradient | 5680.0 | rpm | $itself
table-a-1-nominal-torque | Table A.1: nominal torque, from nominal and no load current | 405.0 | mN m | $itself
table-a-1-stall-torque | Table A.1: stall torque, from the starting current | 8920.0 | mN m | $itself
table-a-1-starting-current | Table A.1: starting current, V/R | 232.0 | A | $itself
table-a-1-efficiency | Table A.1: largest efficiency, (1 - sqrt(I0/IA))^2 | 93.8 | % | $itself
table-a-1-gradient | Table A.1: speed / torque gradient, R/k^2 | 0.668 | rpm/(mN m) | $itself
table-a-1-time-constant | Table A.1: mechanical time constant, J R/k^2 | 3.75 | ms | $itself
table-a-1-speed-constant | Table A.1: speed constant, 1/k | 248.0 | rpm/V | $itself
table-a-1-no-load-current | Table A.1: no load current | 236.0 | mA | datum
table-a-1-nominal-current | Table A.1: nominal current | 10.8 | A | datum
table-a-1-inductance | Table A.1: terminal inductance | 0.072 | mH | datum
table-a-1-resistance | Table A.1: terminal resistance | 0.103 | ohm | datum
table-a-1-torque-constant | Table A.1: torque constant | 38.5 | mN m/A | datum
table-a-1-rotor | Table A.1: rotor inertia beside J11 = 0.0011 of Table 4.1 | 536.0 | g cm^2 | arithmetic
  erratum: J11 of Table 4.1 taken back through the gear; the rotor alone is heavier.
    #erratum-table-4-1-reflected-inertia
## table-a-2 gear_and_encoder: Table A.2
table-a-2-price | Table A.2: price | 131.5 | USD | price
table-a-2-channels | Table A.2: number of channels | 3.0 | | datum
table-a-2-counts | Table A.2: counts per turn | 500 | | input
table-a-2-speed | Table A.2: largest speed | 12000.0 | rpm | datum
## table-a-3 gear_and_encoder: Table A.3
table-a-3-price | Table A.3: price | 544 | USD | price
table-a-3-reduction | Table A.3: reduction | 5.2 | | input
table-a-3-stages | Table A.3: number of stages | 1.0 | | datum
table-a-3-torque | Table A.3: intermittent torque at the output, beside Section 6.5.1
  printed: 12.0 N m
  computed: {output:.3f} N m is called the maximum achievable value
  erratum: that is the continuous rating of the motor. #erratum-4-1-achievable-torque
table-a-3-backlash | Table A.3: average backlash without load
  printed: 1.0 deg, beside a tracking error of 0.055 deg
  computed: {times:.0f} times that error
  erratum: never discussed. #erratum-table-a-3-backlash
table-a-3-inertia | Table A.3: mass inertia, from J11 + J12 of Table 4.1 less the rotor | 109.0 | g cm^2
    | arithmetic within 1 %
  agrees: perhaps chance: the drive pulley would weigh nothing. #erratum-table-4-1-reflected-inertia
table-a-3-input | Table A.3: recommended input speed, beside Section 4.1
  printed: 3000.0 rpm
  computed: driven up to 5680 rpm
  erratum: the print does not mention it. #erratum-table-a-3-input-speed
table-a-3-weight | Table A.3: weight | 950.0 | g | datum
table-a-3-shaft | Table A.3: largest motor shaft diameter | 8.0 | mm | datum
table-a-3-diameter | Table A.3: outer diameter | 62.0 | mm | datum
table-a-3-flange | Table A.3: measurement from flange | 24.0 | mm | datum
""").substitute(itself=ITSELF)
RPM = 2 * pi / 60
VOLTAGE, RESISTANCE = 24.0, 0.103
TORQUE_CONSTANT, NOMINAL_TORQUE, NOMINAL_SPEED = 38.5e-3, 0.405, 5680.0
NO_LOAD_CURRENT, STARTING_CURRENT, ROTOR = 0.236, 232.0, 536e-7


def gear_and_counts() -> tuple[float, float]:
    """Reduction of the gearhead, and counts per turn of the motor itself, by the packaged drive."""
    drive = load_drive("dissertation-3")
    assert drive.motor is not None
    assert drive.motor.gear_ratio is not None
    assert drive.sensors is not None
    assert drive.sensors.motor_encoder is not None
    return drive.motor.gear_ratio, drive.sensors.motor_encoder / drive.motor.gear_ratio


def table_a_1(quick: bool) -> Outcome:
    """Table A.1, the motor: each row from the others where they determine it."""
    constant = TORQUE_CONSTANT
    slope = RESISTANCE / constant**2 / RPM * 1e-3
    free = (VOLTAGE - RESISTANCE * NO_LOAD_CURRENT) / constant / RPM
    found = {
        "power": NOMINAL_TORQUE * NOMINAL_SPEED * RPM,
        "no_load_speed": free,
        "nominal_speed": free - slope * 1e3 * NOMINAL_TORQUE,
        "nominal_torque": 1e3 * constant * (10.8 - NO_LOAD_CURRENT),
        "stall_torque": 1e3 * constant * STARTING_CURRENT,
        "starting_current": VOLTAGE / RESISTANCE,
        "efficiency": 100 * (1 - sqrt(NO_LOAD_CURRENT / STARTING_CURRENT)) ** 2,
        "gradient": slope,
        "time_constant": 1e3 * ROTOR * RESISTANCE / constant**2,
        "speed_constant": 1.0 / constant / RPM,
        "rotor": BENCH_TESTS[0].inertia / gear_and_counts()[0] ** 2 * 1e7,
    }
    return {f"table_a_1_{key}": value for key, value in found.items()}, []


def gear_and_encoder(quick: bool) -> Outcome:
    """Tables A.2 and A.3, the motor's encoder and the gearhead."""
    gear, counts = gear_and_counts()
    less = (BENCH_TESTS[1].inertia / gear**2 - ROTOR) * 1e7
    found = {"table_a_2_counts": counts, "table_a_3_reduction": gear, "table_a_3_inertia": less}
    return found | {"output": NOMINAL_TORQUE * gear, "times": 1.0 / 0.055}, []
