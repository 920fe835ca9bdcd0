"""The laws by name: what each is designed for, its gains and its closed loop."""
