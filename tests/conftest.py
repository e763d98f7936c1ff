"""What every kind of test shares: one hypothesis profile, the tools that scripts/test fetched, and two paths."""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from algorithms.warm_up import have_compiled
from tests import postgresql
from tests.two_processes import pytest_cmdline_main, pytest_xdist_make_scheduler  # noqa: F401 - hooks of pytest

ROOT = Path(__file__).parent.parent

# Derandomised: a red test is red for everybody. Deadlines would measure the machine, not the code.
settings.register_profile("filterroom", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("filterroom")

# A browser and a node that scripts/test had to fetch are found by a plain `pytest` as well.
os.environ["PATH"] = os.pathsep.join([str(ROOT / ".tools" / "bin"), os.environ["PATH"]])
if (node := shutil.which("node")) is not None:
    # Playwright's own node needs a library (libatomic) that a minimal Debian does not have.
    os.environ.setdefault("PLAYWRIGHT_NODEJS_PATH", node)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--database",
        choices=("sqlite", "postgresql"),
        default="sqlite",
        help="what the tests of the database, of the API and of the engine store their rows in",
    )


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Two processes share tests out by their ids: of several with one id a single one would be run, in silence."""
    for item in items:
        # Schemathesis has a test for each operation of the API, and pytest 9.2 leaves its name out of the id.
        if not item.nodeid.endswith(item.name):
            item._id = item.id.with_params(item.name.partition("[")[2].removesuffix("]"))
    twice = [name for name, times in Counter(item.nodeid for item in items).items() if times > 1]
    if twice:
        raise pytest.UsageError(f"several tests have the id {twice[0]}: in two processes only one of them would run")


def pytest_sessionstart(session: pytest.Session) -> None:
    # Tests hold results of this process against those of others, which load what another one compiled.
    have_compiled()


@pytest.fixture(scope="session")
def postgresql_server() -> Iterator[postgresql.PostgreSQL]:
    """A PostgreSQL server that only these tests use."""
    with postgresql.running() as server:
        yield server


@pytest.fixture(scope="session")
def repository() -> Path:
    """The root of the checkout."""
    return ROOT


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Real recordings beside the checkout; not everybody has them."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the folder ../shared/data with real recordings is not beside this checkout")
    return folder
