"""The whole suite runs in two processes, a part of it in this one.

Most of it waits for servers, workers and a browser, which are processes of their own: one test at a time leaves half of
two cores idle. Tests that share an expensive server stay together, others go by file, so nothing is started twice.
`pytest -n 0` runs everything in one process.
"""

from __future__ import annotations

from typing import Any

import pytest

PROCESSES = 2
# One server, and one browser, serve a whole folder.
TOGETHER = ("tests/api/", "tests/browser/")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Start the processes where nothing is said about them and nobody chose tests or wants to look at one."""
    options = config.option
    is_worker = hasattr(config, "workerinput")
    whole = config.args_source is not pytest.Config.ArgsSource.ARGS and not options.keyword
    if is_worker or not config.pluginmanager.hasplugin("xdist") or options.numprocesses is not None:
        return
    if whole and not (options.usepdb or options.collectonly):
        options.numprocesses = PROCESSES
        # The order of the folders: what takes longest comes first, and short files fill the end.
        options.loadscopereorder = False


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Share tests out by file, or by folder."""
    from xdist.scheduler import LoadScopeScheduling

    class ByServer(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return next((folder for folder in TOGETHER if nodeid.startswith(folder)), nodeid.split("::")[0])

    return ByServer(config, log)
