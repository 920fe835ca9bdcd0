"""The axial rigidity of a cable or a rope: given as it is, or by modulus and cross-section."""

from cabledrive.parameters.errors import InputRefused


class Rigidity:
    """What every cable knows of its EA; the fields are those of the class that takes it up."""

    __slots__ = ()
    youngs_modulus: float | None
    area: float | None
    given_rigidity: float | None

    @property
    def axial_rigidity(self) -> float:
        """Axial rigidity EA of one cable [N]."""
        if self.given_rigidity is not None:
            return self.given_rigidity
        assert self.youngs_modulus is not None
        assert self.area is not None
        return self.youngs_modulus * self.area


def check_one_rigidity(cable: Rigidity) -> None:
    """Refuse a rigidity beside modulus or area."""
    if cable.given_rigidity is not None and (cable.youngs_modulus, cable.area) != (None, None):
        raise InputRefused(
            f"axial_rigidity = {cable.given_rigidity:.9g} N beside youngs_modulus or area: give the "
            "rigidity, or modulus and area"
        )
