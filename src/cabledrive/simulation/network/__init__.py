"""Machines with routes in time: every span divided as that of a loop, bodies and pulleys between them."""
