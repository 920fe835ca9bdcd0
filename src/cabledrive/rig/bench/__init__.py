"""The bench: experiments whose logs look like a laboratory's."""
