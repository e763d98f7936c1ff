"""The catalogue of studies: which figures and claims of the papers can be reproduced, and what is claimed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, ConfigDict

from algorithms.studies import Study
from backend.api.algorithms import ReferenceOut
from backend.api.responses import problems
from backend.errors import NotFoundError
from backend.http.etag import conditional

router = APIRouter(prefix="/studies", tags=["studies"])


class _Model(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class ClaimOut(_Model):
    """A statement of a paper."""

    figure: str
    claim: str
    paper: str
    """Its number as printed."""


class StudyEntryOut(_Model):
    """An algorithm of the study's run."""

    name: str
    label: str
    parameters: dict[str, Any]


class StudyOut(_Model):
    """A reproduction of a figure, table or claim: a recipe of one run."""

    name: str
    title: str
    summary: str
    family: str
    paper: ReferenceOut
    item: str
    """Figure, table or section."""
    scenario: str
    scenario_parameters: dict[str, Any]
    algorithms: list[StudyEntryOut]
    sweep: dict[str, list[Any]]
    trials: int
    """Trials where the run says nothing else."""
    seed: int
    claims: list[ClaimOut]

    @classmethod
    def of(cls, study: Study) -> StudyOut:
        """Show a declared study."""
        return cls(
            name=study.name,
            title=study.title,
            summary=study.summary,
            family=study.family,
            paper=ReferenceOut.of(study.paper),
            item=study.item,
            scenario=study.scenario,
            scenario_parameters=dict(study.scenario_parameters),
            algorithms=[
                StudyEntryOut(name=e.name, label=e.label, parameters=dict(e.parameters)) for e in study.entries
            ],
            sweep={name: list(values) for name, values in study.sweep.items()},
            trials=study.trials,
            seed=study.seed,
            claims=[ClaimOut(figure=c.figure, claim=c.claim, paper=c.paper) for c in study.claims],
        )


class StudyList(_Model):
    """All studies."""

    items: list[StudyOut]


def studies() -> Mapping[str, Study]:
    """Return the studies by name."""
    from algorithms.registry import studies_by_name

    return studies_by_name()


@router.get("", name="list_studies", response_model=StudyList, responses=problems())
def list_studies(request: Request) -> Response:
    """List all studies; `POST /api/v1/runs {"study": NAME}` runs one."""
    found = StudyList(items=[StudyOut.of(study) for study in studies().values()])
    return conditional(request, found.model_dump_json().encode(), "application/json")


@router.get("/{name}", name="get_study", response_model=StudyOut, responses=problems(404))
def get_study(name: str, request: Request) -> Response:
    """Show one study."""
    study = studies().get(name)
    if study is None:
        raise NotFoundError(
            f"There is no study {name!r}.", remedy=f"There are: {', '.join(studies())}.", code="study_not_found"
        )
    return conditional(request, StudyOut.of(study).model_dump_json().encode(), "application/json")
