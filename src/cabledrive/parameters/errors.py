"""The two ways a request can end without a result, each told in one line."""


class InputRefused(ValueError):
    """The input cannot be used: what, its value with unit, the bound it met, and the remedy.

    The command line prints the message as one line and ends with status 2; nothing was written.
    """

    def at(self, place: str) -> "InputRefused":
        """Say where: the same refusal with a file or key in front.

        Parameters
        ----------
        place : str
            File name or key path, put before the message and a colon.

        Returns
        -------
        InputRefused
            The refusal with its place.
        """
        return InputRefused(f"{place}: {self}")


class NotComputed(RuntimeError):
    """A calculation could not be completed: what happened and when.

    The command line prints the message as one line, keeps what was found, and ends with status 3.
    """
