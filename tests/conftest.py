"""What the tests share: measured logs, where they are present, and a repeatable Hypothesis."""

from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent
SHARED_DATA = ROOT.parent / "shared" / "data"

settings.register_profile("deterministic", derandomize=True, deadline=None, database=None, print_blob=True)
settings.load_profile("deterministic")


@pytest.fixture(scope="session")
def shared_data():
    """Path of a measured log, by its name below ``../shared/data``; skips the test where it is absent."""

    def path_of(name):
        path = SHARED_DATA / name
        if not path.exists():
            pytest.skip(f"needs the measured log ../shared/data/{name}, which is not here")
        return path

    return path_of
