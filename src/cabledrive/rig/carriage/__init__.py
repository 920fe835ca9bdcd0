"""The carriage that carries a hanging mass along its span, in closed loop."""
