"""The catalogue of algorithms: what each does, takes, gives, and where it comes from."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, ConfigDict

from algorithms.recording import Kind
from algorithms.references import REFERENCES
from algorithms.spec import Algorithm, Reference
from backend.api.responses import problems
from backend.errors import NotFoundError
from backend.http.etag import conditional

router = APIRouter(prefix="/algorithms", tags=["algorithms"])


class _Model(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class OutputOut(_Model):
    """An array of the result."""

    name: str
    axes: list[str]
    unit: str
    meaning: str
    categories: list[str]
    """Meaning of integer codes."""


class ReferenceOut(_Model):
    """Where a method comes from."""

    key: str
    place: str
    text: str
    """In full, as a bibliography has it."""

    @classmethod
    def of(cls, reference: Reference) -> ReferenceOut:
        """Show a reference; one of a plugin that is not in our list of literature is shown by its key."""
        return cls(key=reference.key, place=reference.place, text=REFERENCES.get(reference.key, reference.key))


class AlgorithmOut(_Model):
    """An algorithm of the catalogue."""

    name: str
    title: str
    summary: str
    family: str
    recommended: bool
    """The one of its family to begin with."""
    takes: list[Kind]
    """Kinds of recordings."""
    parameters_schema: dict[str, Any]
    """JSON Schema with unit, symbol, group, choices and fallback of every parameter: enough to make a form of it."""
    outputs: list[OutputOut]
    charts: list[str]
    references: list[ReferenceOut]

    @classmethod
    def of(cls, algorithm: Algorithm) -> AlgorithmOut:
        """Show a declared algorithm."""
        return cls(
            name=algorithm.name,
            title=algorithm.title,
            summary=algorithm.summary,
            family=algorithm.family,
            recommended=algorithm.recommended,
            takes=list(algorithm.takes),
            parameters_schema=algorithm.parameters.schema_for_forms(),
            outputs=[
                OutputOut(
                    name=o.name,
                    axes=list(o.axes),
                    unit=o.unit,
                    meaning=o.meaning,
                    categories=list(o.categories),
                )
                for o in algorithm.outputs
            ],
            charts=list(algorithm.charts),
            references=[ReferenceOut.of(r) for r in algorithm.references],
        )


class AlgorithmList(_Model):
    """All algorithms."""

    items: list[AlgorithmOut]


def catalogue() -> dict[str, Algorithm]:
    """Return the algorithms by name; the first call imports their compiled kernels, which takes seconds."""
    from algorithms.registry import algorithms_by_name

    return algorithms_by_name()


def references_of(names: Iterable[str]) -> list[ReferenceOut]:
    """Return what these algorithms cite, each once; nothing for one that is no longer installed."""
    found = [catalogue()[name] for name in names if name in catalogue()]
    return [ReferenceOut.of(r) for r in dict.fromkeys(r for a in found for r in a.references)]


@router.get("", name="list_algorithms", response_model=AlgorithmList, responses=problems())
def list_algorithms(request: Request) -> Response:
    """List all algorithms with their parameters."""
    found = AlgorithmList(items=[AlgorithmOut.of(a) for a in catalogue().values()])
    return conditional(request, found.model_dump_json().encode(), "application/json")


@router.get("/{name}", name="get_algorithm", response_model=AlgorithmOut, responses=problems(404))
def get_algorithm(name: str, request: Request) -> Response:
    """Show one algorithm."""
    algorithm = catalogue().get(name)
    if algorithm is None:
        raise NotFoundError(
            f"There is no algorithm {name!r}.",
            remedy=f"There are: {', '.join(catalogue())}.",
            code="algorithm_not_found",
        )
    return conditional(request, AlgorithmOut.of(algorithm).model_dump_json().encode(), "application/json")
