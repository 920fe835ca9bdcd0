"""Models of few equations that keep what matters, each with the limits within which it may be trusted."""
