"""A body held between two motors on the virtual rig: position and tension controlled together."""
