"""The packaged drives of the dissertation as two pulleys, which its closed forms are about."""

from cabledrive.parameters import Drive, load_drive
from cabledrive.parameters.route.two_pulleys import two_pulleys_of


def packaged(name: str) -> Drive:
    """The drive with two pulleys of a packaged file."""
    return two_pulleys_of(load_drive(name), "the dissertation")
