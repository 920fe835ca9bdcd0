"""One rigid axis: its regression, the instant of its torque, other methods, and whether its model holds."""
