"""Control laws as pure steps over frozen gains; nothing here knows a simulation.

In every file of this room ``interval`` is the sample time [s], ``counts`` one count of each encoder, seen at
the first shaft [rad], ``states`` angles, then speeds, from the motor to the load, ``reference`` the rows of
`cabledrive.control.reference.flat_generator`, ``delta`` a bound of the disturbance [N m].
"""

from cabledrive.control.own_controller import OwnController

__all__ = ["OwnController"]
