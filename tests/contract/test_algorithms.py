"""One suite over every registered algorithm and scenario: what each must hold, whatever it computes."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from algorithms.errors import InputError, RunCancelled
from algorithms.recording import Recording
from algorithms.references import REFERENCES
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.result import Output, Result
from algorithms.spec import Algorithm, LocalContext
from algorithms.toolbox.kernels.symmetric import unpack

ALGORITHMS = list(algorithms_by_name().values())
SCENARIOS = list(scenarios_by_name().values())
GROUPS = {"measurement", "motion", "association", "start", "smoothing", "output"}

each_algorithm = pytest.mark.parametrize("algorithm", ALGORITHMS, ids=lambda a: a.name)
each_of_marks = pytest.mark.parametrize(
    "algorithm", [a for a in ALGORITHMS if a.family == "multilateration"], ids=lambda a: a.name
)


# Of more presets than these, those that are simulated in the same way say nothing new about an algorithm.
MANY_PRESETS = 6
# Enough for every algorithm to begin, and to be past its beginning.
ROWS = 30


def recordings(algorithm: Algorithm, trials: tuple[int, ...] = (0,), rows: int = 120) -> list[Recording]:
    own = [s for s in SCENARIOS if s.family == algorithm.family and s.kind in algorithm.takes]
    if len(own) > MANY_PRESETS:
        own = list({s.simulate: s for s in reversed(own)}.values())
    made = [s.simulate(s.parameters(), trials, 11) for s in own]
    assert made, "a family needs a scenario that its algorithms can run on"
    return [r.take(np.arange(min(rows, len(r)))) for r in made]


def run(algorithm: Algorithm, recording: Recording) -> Result:
    return algorithm.run(recording, algorithm.parameters(), LocalContext())


def test_something_is_registered() -> None:
    assert {"single_mark", "rdf", "rdfv"} <= set(algorithms_by_name())
    assert {"four_station_circuit", "four_station_incomplete"} <= set(scenarios_by_name())


def test_each_family_recommends_one() -> None:
    found = algorithms_by_name().values()
    recommended = [a.family for a in found if a.recommended]
    assert sorted(recommended) == sorted({a.family for a in found if a.family != "rehearsal"})


@each_algorithm
def test_declaration_is_complete(algorithm: Algorithm) -> None:
    assert algorithm.title
    assert algorithm.summary.endswith(".")
    assert algorithm.charts
    for reference in algorithm.references:
        assert reference.key in REFERENCES
    schema = algorithm.parameters.schema_for_forms()
    assert schema["additionalProperties"] is False
    for name, field in schema["properties"].items():
        assert field.get("title"), name
        assert field.get("description"), name
        assert field["group"] in GROUPS, name
        assert "default" in field, name
    words = {w for f in schema["properties"].values() for w in f.get("choices", {})}
    assert all(isinstance(w, str) for w in words)
    module = sys.modules[algorithm.run.__module__]
    assert module.__doc__ is not None
    assert "ifferences from the paper" in module.__doc__


@each_algorithm
def test_outputs_are_as_declared(algorithm: Algorithm) -> None:
    for recording in recordings(algorithm):
        result = run(algorithm, recording)
        assert set(result.arrays) == {o.name for o in algorithm.outputs}
        for output in algorithm.outputs:
            array = result.arrays[output.name]
            assert array.ndim == len(output.axes), output.name
            if output.categories and array.size:
                assert array.min() >= 0
                assert array.max() < len(output.categories)
            if array.dtype.kind == "f":
                assert not np.isinf(array).any(), output.name
            if output.axes.count("component") == 2:
                assert_covariances(matrices(output, array), output.name)
            if "triangle" in output.axes:
                axis = output.axes.index("triangle")
                axes = (*output.axes[:axis], "component", "component", *output.axes[axis + 1 :])
                assert_covariances(matrices(replace(output, axes=axes), unpack(array, axis)), output.name)
            if output.unit == "probability":
                assert_probabilities(output, array)


def matrices(output: Output, array: np.ndarray) -> np.ndarray:
    """Matrices of an output with two axes `component`, one after the other, of the components that it knows."""
    first = output.axes.index("component")
    assert output.axes[first + 1] == "component", "the two axes of a matrix stand side by side"
    p = np.moveaxis(array, (first, first + 1), (-2, -1))
    n = p.shape[-1]
    p = p.reshape(-1, n, n)
    known = np.isfinite(np.diagonal(p, axis1=1, axis2=2)).any(axis=0)
    p = p[:, known][:, :, known]
    return p[np.isfinite(p).all(axis=(1, 2))]


def assert_covariances(p: np.ndarray, name: str) -> None:
    assert len(p), name
    assert (p == p.transpose(0, 2, 1)).all(), f"{name}: symmetric to the bit"
    variances = np.diagonal(p, axis1=1, axis2=2)
    assert (variances >= 0).all(), name
    # Correlations, because the components have different units; a start may be certain of a component.
    scale = np.sqrt(np.where(variances > 0, variances, 1.0))
    correlation = p / scale[:, :, None] / scale[:, None, :]
    assert (np.linalg.eigvalsh(correlation)[:, 0] > -1e-9).all(), name


def assert_probabilities(output: Output, array: np.ndarray) -> None:
    """Probabilities lie between 0 and 1; over an axis `model` or `candidate` they sum to one."""
    known = array[np.isfinite(array)]
    assert ((known >= 0) & (known <= 1 + 1e-12)).all(), output.name
    for axis in ("model", "candidate"):
        if axis in output.axes:
            total = array.sum(axis=output.axes.index(axis))
            assert np.allclose(total[np.isfinite(total)], 1.0, atol=1e-9), output.name


@each_algorithm
def test_tables_and_metrics(algorithm: Algorithm) -> None:
    for recording in recordings(algorithm):
        result = run(algorithm, recording)
        tables = algorithm.tabulate(recording, result)
        for name, table in tables.items():
            assert len({len(c) for c in table.columns.values()}) == 1, name
            assert list(table.rows()) == list(type(table).from_arrays(table.to_arrays("t"), "t").rows())
        assert {"decisions", "associations"} & set(tables), "every algorithm tells what it decided"
        if "states" in tables and recording.has_truth:
            assert "errors" in tables
        if algorithm.family == "multilateration":
            assert {"states", "tracks", "decisions", "errors"} <= set(tables)
        metrics = algorithm.measure(recording, result)
        assert len({(m.metric, m.target, m.segment) for m in metrics}) == len(metrics)
        for m in metrics:
            assert m.value is None or np.isfinite(m.value)


def digest(name: str) -> str:
    algorithm = algorithms_by_name()[name]
    state = hashlib.sha256()
    for recording in recordings(algorithm, trials=tuple(range(18)), rows=ROWS):
        for key, array in sorted(run(algorithm, recording).arrays.items()):
            state.update(key.encode() + np.ascontiguousarray(array).tobytes())
    return state.hexdigest()


@pytest.fixture(scope="module")
def digests_of_another_process() -> dict[str, str]:
    """One process for all algorithms: to start one takes longer than to compute."""
    code = (
        "import json; from tests.contract.test_algorithms import ALGORITHMS, digest; "
        "print(json.dumps({a.name: digest(a.name) for a in ALGORITHMS}))"
    )
    environment = {**os.environ, "PYTHONHASHSEED": "7"}
    other = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, check=True, env=environment)
    return dict(json.loads(other.stdout))


@pytest.mark.slow  # all algorithms once more, in a process that has to load them first
@each_algorithm
def test_the_same_bytes_in_another_process(algorithm: Algorithm, digests_of_another_process: dict[str, str]) -> None:
    assert digests_of_another_process[algorithm.name] == digest(algorithm.name)


@each_algorithm
def test_the_same_bytes_under_another_cut(algorithm: Algorithm) -> None:
    """Trials in one block, or seven here and eleven there: a trial's bytes stay."""
    whole = recordings(algorithm, trials=tuple(range(18)), rows=ROWS)
    first = recordings(algorithm, trials=tuple(range(7)), rows=ROWS)
    second = recordings(algorithm, trials=tuple(range(7, 18)), rows=ROWS)
    for w, a, b in zip(whole, first, second, strict=True):
        full, left, right = run(algorithm, w).arrays, run(algorithm, a).arrays, run(algorithm, b).arrays
        for output in algorithm.outputs:
            if output.axes[-1] == "trial":
                joined = np.concatenate([left[output.name], right[output.name]], axis=-1)
                assert joined.tobytes() == full[output.name].tobytes(), output.name


@each_algorithm
def test_cancel_is_honoured(algorithm: Algorithm) -> None:
    class Cancelled(LocalContext):
        def check_cancelled(self) -> None:
            raise RunCancelled

    with pytest.raises(RunCancelled):
        algorithm.run(recordings(algorithm)[0], algorithm.parameters(), Cancelled())


@each_algorithm
def test_progress_ends_at_one(algorithm: Algorithm) -> None:
    shares: list[float] = []

    class Watched(LocalContext):
        def progress(self, share: float) -> None:
            shares.append(share)

    algorithm.run(recordings(algorithm)[0], algorithm.parameters(), Watched())
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)


@each_algorithm
def test_empty_and_single_rows(algorithm: Algorithm) -> None:
    recording = recordings(algorithm)[0]
    for rows in (0, 1):
        part = recording.take(np.arange(rows))
        result = run(algorithm, part)
        algorithm.tabulate(part, result)
        algorithm.measure(part, result)
        for output in algorithm.outputs:
            if output.axes[0] == "mark":
                assert len(result.arrays[output.name]) == rows, output.name


@each_algorithm
def test_bounds_end_points_work(algorithm: Algorithm) -> None:
    """The smallest and largest allowed value of every number gives no infinity, or says what is wrong with it."""
    recording = recordings(algorithm, rows=40)[0]
    for name, field in algorithm.parameters.model_json_schema()["properties"].items():
        numbers = [f for f in [field, *field.get("anyOf", ())] if f.get("type") in ("number", "integer")]
        for f in numbers:
            ends = [f[k] for k in ("minimum", "maximum", "exclusiveMaximum") if k in f]
            if "exclusiveMinimum" in f:
                ends.append(f["exclusiveMinimum"] + 1e-6)
            for value in ends:
                refusal, arrays = ran(algorithm, recording, **{name: value})
                assert refusal is None or refusal, (name, value)
                for output, array in arrays.items():
                    assert array.dtype.kind != "f" or not np.isinf(array).any(), (name, value, output)


def ran(algorithm: Algorithm, recording: Recording, **parameters: float) -> tuple[str | None, Mapping[str, np.ndarray]]:
    """What is wrong with the parameters, in words, or the arrays."""
    try:
        return None, algorithm.run(recording, algorithm.parameters(**parameters), LocalContext()).arrays
    except InputError as error:
        return error.remedy, {}
    except ValidationError as error:
        # It does not go together with the default of another.
        return error.errors()[0]["msg"], {}


@each_of_marks
def test_targets_are_kept_apart(algorithm: Algorithm) -> None:
    """Two emitters in one recording give what each gives alone."""
    one = recordings(algorithm)[0]
    alone = run(algorithm, one).arrays["state"]
    n = len(one)
    both = one.take(np.repeat(np.arange(n), 2))
    both = replace(both, target=np.tile([0, 1], n), targets=("a", "b"))
    result = run(algorithm, both)
    for target in (0, 1):
        assert result.arrays["state"][both.rows_of(target)].tobytes() == alone.tobytes()
    tracks = result.arrays["track"]
    assert not set(tracks[both.rows_of(0)].ravel()) & set(tracks[both.rows_of(1)].ravel()) - {0}
