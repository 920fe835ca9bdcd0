"""The drive as a laboratory sees it: sampled, counted, delayed, limited, with friction that sticks."""
