"""What the routers work with, made once per server."""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Request

from backend.db.engine import Database
from backend.files.store import Store
from backend.http.changes import Changes
from backend.jobs.engine import Engine
from backend.settings import Settings


@dataclass(frozen=True)
class Services:
    """The parts of a running server."""

    settings: Settings
    database: Database
    store: Store
    engine: Engine
    changes: Changes
    started_at: dt.datetime


# Not a plain function, for which every request would wait for a thread.
async def _services(request: Request) -> Services:
    services = request.app.state.services
    assert isinstance(services, Services)
    return services


ServicesDep = Annotated[Services, Depends(_services)]
