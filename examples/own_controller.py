"""How is a controller of your own run on the virtual rig? PD on the motor, integral at the load."""

import cabledrive as cd


def step(gains, state, measurement, reference):
    error = reference[:-1] - measurement  # of motor and load [rad], then their speeds [rad/s]
    state = state + 2e-4 * error[1]
    return state, reference[-1] + gains[0] * error[0] + gains[1] * error[2] + gains[2] * state[0]


mine = cd.OwnController(step=step, gains=(8.0, 0.3, 20.0), initial_state=[0.0], shafts=("motor", "load"))
run = cd.track(cd.load_drive("dissertation-3"), controller=mine)
print(f"peak error {run.summary['peak_error_deg']:.3f} deg; plain Python: {run.interpreted}")
assert run.summary["peak_error_deg"] < 0.2
