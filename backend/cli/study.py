"""`filterroom study`: a reproduction of a paper's figure, on all processors, without a server."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import signal
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import TYPE_CHECKING, Any

from backend.cli import outputs
from backend.cli.outputs import LocalRun, prepared_folder, write_outputs
from backend.cli.run import succeeded
from backend.cli.terminal import DONE, ProgressBar, UsageError

if TYPE_CHECKING:
    from algorithms.studies import Study
    from backend.jobs.outcome import Outcome
    from backend.jobs.plan import TrialsPlan
    from backend.jobs.work import TrialsBlock


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the command."""
    parser.add_argument("name", metavar="NAME", help="name of the study; a wrong one lists them")
    parser.add_argument("--trials", type=int, help="simulated trials (default: as the study says)")
    parser.add_argument("--seed", type=int, help="seed of the random streams (default: as the study says)")
    parser.add_argument("--workers", type=int, help="processes (default: one per processor)")
    outputs.add_arguments(parser)


def study(options: argparse.Namespace) -> int:
    """Simulate, compute, judge the claims, print them, write what was asked for."""
    from algorithms.registry import studies_by_name
    from backend.jobs.gathering import gathered
    from backend.jobs.trial_results import compose

    declared = studies_by_name().get(options.name)
    if declared is None:
        raise UsageError(f"There is no study {options.name!r}; there are {', '.join(studies_by_name())}.")
    if options.workers is not None and options.workers < 1:
        raise UsageError("--workers: at least one process is needed.")
    source, entries, plan, seed = _planned(declared, options)
    prepared_folder(options.out, options.overwrite)
    with ProgressBar(declared.name) as bar:
        blocks = _computed(plan, seed, options.workers or os.cpu_count() or 1, bar.show)
    composed = compose(gathered(plan, blocks), declared.name)
    finished = LocalRun(declared.title, entries, source, _first_trial(composed.arrays), composed)
    claims = _claims(composed)
    about = {
        "study": declared.name,
        "title": declared.title,
        "trials": source["trials"],
        "seed": seed,
        "claims": claims,
        "summary": composed.summary,
        "entries": composed.entries,
        "software": composed.software,
    }
    if options.out is not None:
        with ProgressBar("writing") as bar:
            about["files"] = write_outputs(options.out, finished, about, bar.show, language=options.language)
    print(json.dumps(about, ensure_ascii=False) if options.json else "\n".join(_lines(about, options)))
    return DONE


def _planned(declared: Study, options: argparse.Namespace) -> tuple[dict[str, Any], list[Any], TrialsPlan, int]:
    """Spread the study out, with the same checks as the server's."""
    from pydantic import ValidationError

    from backend.api.run_request import spread_out
    from backend.api.run_scenario import checked_scenario
    from backend.api.run_schemas import RunIn
    from backend.db.runs import Entry

    try:
        request = spread_out(RunIn(study=declared.name, trials=options.trials, seed=options.seed))
    except ValidationError as error:
        first = error.errors()[0]
        raise UsageError(f"--{first['loc'][0]}: {first['msg']}.") from error
    entries = [Entry(e.name, e.label or e.name, e.parameters) for e in request.algorithms]
    scenario, problems = checked_scenario(request, entries)
    if scenario is None:
        raise UsageError(" ".join(p.detail for p in problems))
    source = {**scenario.source, "study": declared.name, "trials": scenario.trials}
    return source, entries, scenario.plan, request.seed or 0


def _computed(plan: TrialsPlan, seed: int, workers: int, show: Callable[[float], None]) -> dict[int, Mapping[str, Any]]:
    """Compute all blocks in processes of their own; the result is the same for any number of them."""
    from algorithms.errors import AlgorithmError
    from backend.jobs.ledger import trials_block
    from backend.jobs.outcome import block_arrays

    done: dict[int, Mapping[str, Any]] = {}
    pool = ProcessPoolExecutor(
        min(workers, plan.size), mp_context=multiprocessing.get_context("spawn"), initializer=_begin
    )
    try:
        waiting = {
            pool.submit(_run, trials_block(plan, position, token=str(position), seed=seed)): position
            for position in range(plan.size)
        }
        while waiting:
            finished, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                done[waiting.pop(future)] = block_arrays(succeeded(future.result()))
                show(len(done) / plan.size)
    except BrokenProcessPool as error:
        raise AlgorithmError(
            "A process ended in the middle of its trials.",
            remedy="Most often it ran out of memory: use fewer --workers.",
            code="worker_died",
        ) from error
    except BaseException:
        # Whatever ended us, the processes must not go on computing for nobody.
        for child in multiprocessing.active_children():
            child.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
    return dict(sorted(done.items()))


def _begin() -> None:
    """Ctrl-C reaches every process of the terminal; the first one alone decides what follows."""
    from backend.jobs.worker_memory import keep_freed_memory

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    keep_freed_memory()


def _run(block: TrialsBlock) -> Outcome:
    from backend.jobs.work import run_block

    return run_block(block, lambda _: None)


def _first_trial(arrays: Mapping[str, Any]) -> Any:
    from algorithms.recording import recording_from_arrays

    prefix = "recording/"
    own = {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
    return recording_from_arrays(own)


def _claims(composed: Any) -> list[dict[str, Any]]:
    (table,) = (t for t in composed.tables if t.name == "claims")
    names = [name for name, _ in table.columns]
    return [dict(zip(names, row, strict=True)) for row in table.rows]


def _lines(about: Mapping[str, Any], options: argparse.Namespace) -> list[str]:
    from backend.charts.report import number_text

    # A sweep has hundreds of numbers: they are for --out and --json.
    out = [f"{about['title']}: {about['trials']} trials, seed {about['seed']}."]
    for claim in about["claims"]:
        known = claim["ci95_low"] is not None and claim["ci95_high"] is not None
        interval = (claim["ci95_low"], claim["ci95_high"]) if known else None
        value = f"; here {number_text(claim['value'], interval)} {claim['unit']}".rstrip()
        out.append(f"{claim['verdict']}: {claim['figure']}: {claim['claim']} (paper: {claim['paper']}{value})")
        out.append(f"  {claim['reason']}")
    if options.out is not None:
        out.append(f"{len(about['files'])} files are in {options.out}.")
    return out
