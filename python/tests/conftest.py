from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture
def reference() -> Path:
    return REPOSITORY / "results" / "reference"
