"""Models 1 to 4 of a drive as text in Modelica, without any library."""

from cabledrive.export.drive_source import lumped_models
from cabledrive.export.shells import templates
from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.version import __version__


def modelica_files(drive: Drive) -> dict[str, str]:
    """One model for each of the Models 1 to 4 that the drive's data allow."""
    template = templates().get_template("model.mo.jinja")
    return {
        f"Model{n}.mo": template.render(
            number=n, drive=drive, chain=chain, version=__version__, hash=content_hash(drive), repr=repr
        )
        for n, chain in lumped_models(drive).items()
    }
