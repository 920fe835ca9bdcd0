"""A fault or a doubt that a reader must act on: a sentence with a code."""


class Finding(str):
    """A sentence that has a code, for programs that read the answer.

    Attributes
    ----------
    code : str
        Short and lasting: "model-misfit".
    """

    __slots__ = ("code",)
    code: str

    def __new__(cls, code: str, message: str) -> "Finding":
        """Make one."""
        made = super().__new__(cls, message)
        made.code = code
        return made

    @property
    def message(self) -> str:
        """The sentence."""
        return str(self)

    def as_dict(self) -> dict[str, str]:
        """The finding as JSON has it."""
        return {"code": self.code, "message": str(self)}


def code_of(finding: str) -> str:
    """Code of a finding; "finding" where it is a plain sentence."""
    return finding.code if isinstance(finding, Finding) else "finding"
