"""Control laws as pure steps over frozen gains; nothing here knows a simulation."""
