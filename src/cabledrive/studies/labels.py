"""What every labelled result says about itself."""

from typing import TYPE_CHECKING

from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.route import RoutedDrive

if TYPE_CHECKING:
    import xarray as xr


def stamped(data: "xr.Dataset", drive: Drive | RoutedDrive, title: str) -> "xr.Dataset":
    """Add title, drive, hash, version and method to a result.

    ``drive``: the drive it was computed from; ``title``: what it shows.
    Returns the same data with attributes.
    """
    from cabledrive.parameters.version import __version__

    return data.assign_attrs(
        title=title,
        drive=drive.name,
        drive_hash=content_hash(drive),
        version=__version__,
        method="exact dynamic stiffness, modes isolated by counting",
    )
