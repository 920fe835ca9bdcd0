"""The chain methods in numpy, line by line as their formulas: oracles of the compiled steps."""
