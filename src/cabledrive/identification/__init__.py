"""From a log to parameters with intervals: inverse dynamics, frequency response, output error."""
