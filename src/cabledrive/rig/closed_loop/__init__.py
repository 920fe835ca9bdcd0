"""The sampled loop: plant, encoders, filter and law, step by step in compiled code."""
