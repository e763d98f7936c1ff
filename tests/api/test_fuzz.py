"""Whatever the description allows, and much that it does not: the server answers as described and never with 500."""

from __future__ import annotations

import pytest
import schemathesis
from hypothesis import HealthCheck, settings
from schemathesis import Case
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from backend.app import api_description
from tests.api.conftest import TOKEN, ServerProcess

# Streams do not end; they have tests of their own.
schema = schemathesis.openapi.from_dict(api_description()).exclude(path_regex="/events$")
CHECKS = (not_a_server_error, status_code_conformance, content_type_conformance, response_schema_conformance)


@pytest.mark.slow
@schema.parametrize()
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
def test_every_operation_answers_as_described(case: Case, server: ServerProcess) -> None:
    answer = case.call(base_url=server.url, headers={"Authorization": f"Bearer {TOKEN}"})
    case.validate_response(answer, checks=list(CHECKS))
