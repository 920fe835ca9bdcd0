"""Modes of machines with routes: the exact dynamic stiffness of a network, counted and refined."""
