"""Puts the server together: services, routes, and what every request passes through."""

from __future__ import annotations

import asyncio
import importlib
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from fastapi import APIRouter, FastAPI
from starlette.concurrency import run_in_threadpool
from starlette.middleware.gzip import GZipMiddleware

from backend.api import (
    accuracy_map,
    algorithms,
    charts,
    compare,
    documentation,
    events,
    exports,
    page_files,
    problem_pages,
    recording_exports,
    recording_preview,
    recordings,
    run_estimate,
    run_report,
    runs,
    scenario_tracks,
    scenarios,
    service,
    studies,
    tables,
    targets,
)
from backend.api.recording_schemas import ReadAgain
from backend.api.samples import import_samples
from backend.api.services import Services
from backend.db.engine import Database
from backend.db.ids import now
from backend.files.lock import DataFolderLock
from backend.files.options import ReadOptions
from backend.files.store import Store
from backend.http import problems
from backend.http.allowed_hosts import AllowedHosts
from backend.http.body_limit import BodyLimit
from backend.http.changes import Changes
from backend.http.cross_site import CrossSite
from backend.http.security_headers import SecurityHeaders
from backend.http.token_gate import TokenGate
from backend.http.unexpected_errors import UnexpectedErrors
from backend.jobs.engine import Engine
from backend.settings import Settings
from backend.version import program_version

_DESCRIPTION = (
    "Reprocess recordings of radars and multilateration systems, and see how far to trust the tracks. "
    "Errors are problem details (RFC 9457); units stand in the names; times are ISO 8601 in UTC."
)
_WILDCARD_HOSTS = ("0.0.0.0", "::", "")  # noqa: S104 - recognised, not bound


def create_app(settings: Settings) -> FastAPI:
    """Return the application; it holds the data folder from now until its lifespan ends.

    Raises
    ------
    StateError
        Another server uses the data folder, or a newer version has written it.
    StorageError
        The data folder cannot be used.
    """
    lock = DataFolderLock(settings.data_dir)
    lock.acquire()
    try:
        services = _open(settings)
    except BaseException:
        lock.release()
        raise

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        services.changes.attach(asyncio.get_running_loop())
        stop_listening = services.database.listen(services.changes.notify)
        # Whatever an earlier server left half done is taken up before the first request comes.
        await run_in_threadpool(services.engine.start)
        stopping = threading.Event()
        getting_ready = asyncio.create_task(_get_ready(services, stopping))
        try:
            yield
        finally:
            stopping.set()
            getting_ready.cancel()
            services.changes.close()
            stop_listening()
            await run_in_threadpool(services.engine.stop)
            services.database.close()
            lock.release()

    app = _bare(lifespan=lifespan)
    app.state.services = services
    page_files.serve_page(app)
    _protect(app, settings)
    return app


def api_description() -> dict[str, Any]:
    """Return the OpenAPI document; nothing is opened or started for it."""
    return _bare().openapi()


def _open(settings: Settings) -> Services:
    from backend.db.migrate import upgrade

    database = Database(settings.url)
    upgrade(database)
    store = Store(settings.store_dir)
    engine = Engine(database, store, settings)
    return Services(settings, database, store, engine, Changes(), started_at=now())


async def _get_ready(services: Services, stopping: threading.Event) -> None:
    # The first page comes first.
    await asyncio.sleep(0.5)
    if services.settings.samples:
        await run_in_threadpool(import_samples, services)
    # Then the workers, which have more to do.
    while services.engine.state == "starting":
        await asyncio.sleep(0.2)
    threading.Thread(target=_load_methods, args=(stopping,), name="methods", daemon=True).start()


def _load_methods(stopping: threading.Event) -> None:
    """Import algorithms, then charts, which takes two seconds: else the first run and its first chart wait for them."""
    from algorithms.registry import module_names

    for name in module_names():
        if stopping.is_set():
            return
        importlib.import_module(name)
    from backend.charts.catalogue import charts as charts_of

    charts_of("run")


def _bare(**options: Any) -> FastAPI:
    app = FastAPI(
        title="Filter Room",
        version=program_version(),
        description=_DESCRIPTION,
        docs_url=None,
        redoc_url=None,
        # Paths have one spelling: no redirects between with and without a slash.
        redirect_slashes=False,
        generate_unique_id_function=lambda route: route.name,
        # Without a collector the spans cost a fifth of the requests per second and tell nobody anything.
        telemetry={"tracing": False, "metrics": False, "logs": False, "operation_spans": False},
        **options,
    )
    problems.install(app)
    api = APIRouter(prefix="/api/v1")
    for module in (
        algorithms,
        scenario_tracks,
        scenarios,
        studies,
        accuracy_map,
        recordings,
        recording_exports,
        recording_preview,
        targets,
        run_estimate,
        runs,
        tables,
        exports,
        run_report,
        charts,
        compare,
        events,
        service,
    ):
        api.include_router(module.router)
    api.include_router(runs.tags_router)
    app.include_router(api)
    app.include_router(service.health)
    app.include_router(documentation.router)
    app.include_router(problem_pages.router)
    app.include_router(page_files.router)
    _describe(app)
    return app


def _protect(app: FastAPI, settings: Settings) -> None:
    """Add what every request passes through; the last one added comes first."""
    own_host = () if settings.host in _WILDCARD_HOSTS else (_bracketed(settings.host),)
    token = None if settings.insecure_no_token else settings.read_token()
    # Levels above 3 save a few percent of an answer and double its time.
    app.add_middleware(GZipMiddleware, minimum_size=1000, compresslevel=3)
    app.add_middleware(BodyLimit, json_bytes=settings.max_json_bytes, upload_bytes=settings.max_upload_bytes)
    app.add_middleware(CrossSite)
    app.add_middleware(TokenGate, token=token, instance_id=settings.read_instance_id())
    app.add_middleware(AllowedHosts, hosts=(*own_host, *settings.allowed_hosts))
    app.add_middleware(UnexpectedErrors)
    app.add_middleware(SecurityHeaders)


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _describe(app: FastAPI) -> None:
    """Complete the generated OpenAPI document: problems, the body of an upload, the token."""
    generated = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            document = generated()
            schemas = document["components"]["schemas"]
            for model in (problems.Problem, ReadAgain, ReadOptions):
                schema = model.model_json_schema(ref_template="#/components/schemas/{model}")
                schemas |= schema.pop("$defs", {})
                schemas[model.__name__] = schema
            document["components"]["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
            for path, operations in document["paths"].items():
                if path.startswith("/api/"):
                    for operation in operations.values():
                        operation["security"] = [{"token": []}]
            app.openapi_schema = document
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]
