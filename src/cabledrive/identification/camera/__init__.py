"""Motion of a painted marker from the frames of a camera, section 4.1, as a log like any other."""
