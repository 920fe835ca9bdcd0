"""Tables A.1 to A.3: what of the data sheets follows from the rest of them, and what stands alone."""

from math import pi, sqrt

from reproduction.bench import BENCH_TESTS
from reproduction.drives import packaged
from reproduction.items import Outcome

RPM = 2 * pi / 60
VOLTAGE, RESISTANCE = 24.0, 0.103
TORQUE_CONSTANT, NOMINAL_TORQUE, NOMINAL_SPEED = 38.5e-3, 0.405, 5680.0
NO_LOAD_CURRENT, STARTING_CURRENT, ROTOR = 0.236, 232.0, 536e-7


def gear_and_counts() -> tuple[float, float]:
    """Reduction of the gearhead, and counts per turn of the motor itself, by the packaged drive."""
    drive = packaged("dissertation-3")
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
    found = {"power": NOMINAL_TORQUE * NOMINAL_SPEED * RPM, "no_load_speed": free, "gradient": slope}
    found |= {"nominal_speed": free - slope * 1e3 * NOMINAL_TORQUE, "speed_constant": 1.0 / constant / RPM}
    found |= {
        "nominal_torque": 1e3 * constant * (10.8 - NO_LOAD_CURRENT),
        "starting_current": VOLTAGE / RESISTANCE,
    }
    found |= {"stall_torque": 1e3 * constant * STARTING_CURRENT}
    found |= {"efficiency": 100 * (1 - sqrt(NO_LOAD_CURRENT / STARTING_CURRENT)) ** 2}
    found |= {"time_constant": 1e3 * ROTOR * RESISTANCE / constant**2}
    found |= {"rotor": BENCH_TESTS[0].inertia / gear_and_counts()[0] ** 2 * 1e7}
    return {f"table_a_1_{key}": value for key, value in found.items()}, []


def gear_and_encoder(quick: bool) -> Outcome:
    """Tables A.2 and A.3, the motor's encoder and the gearhead."""
    gear, counts = gear_and_counts()
    less = (BENCH_TESTS[1].inertia / gear**2 - ROTOR) * 1e7
    found = {"table_a_2_counts": counts, "table_a_3_reduction": gear, "table_a_3_inertia": less}
    return found | {"output": NOMINAL_TORQUE * gear, "times": 1.0 / 0.055}, []
