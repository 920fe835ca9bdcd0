"""The laws side by side: tuned by one procedure, run on the same plants, with margins and cost."""
