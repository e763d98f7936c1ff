"""The paper's rivals with one model: Kalman filters that differ in kind and noise alone.

Differences from the paper: initiation and long gaps are ours (see `parameters`).
"""

from __future__ import annotations

from algorithms.multiple_model.answers import run_models, score_models
from algorithms.multiple_model.bound import horizontal_bound
from algorithms.multiple_model.charts import PLAIN_CHARTS
from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.measures import measure
from algorithms.multiple_model.outputs import OUTPUTS
from algorithms.multiple_model.parameters import PaperKalmanParameters
from algorithms.multiple_model.tables import tabulate
from algorithms.multiple_model.tracker import ModelSet
from algorithms.result import Result
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext


def one_model(name: str, title: str, summary: str, kind: str, sigma_mps2: float) -> Algorithm:
    """Return the algorithm with one model of this kind and noise, of the step form at 0.05 s."""
    models = ModelSet(((kind, sigma_mps2),))

    def run(recording: Plots, parameters: PaperKalmanParameters, context: RunContext) -> Result:
        return run_models(recording, parameters, models, context)

    def score(recording: Plots, parameters: PaperKalmanParameters, context: RunContext) -> Scores:
        return score_models(recording, parameters, models, context)

    return Algorithm(
        name=name,
        title=title,
        summary=summary,
        family="multiple_model",
        takes=("antenna_plots", "polar_plots"),
        parameters=PaperKalmanParameters,
        outputs=OUTPUTS,
        charts=PLAIN_CHARTS,
        references=(Reference("trudymai2023", "section 3"), Reference("barshalom2001")),
        run=run,
        tabulate=tabulate,
        measure=measure,
        score=score,
        bound=horizontal_bound,
    )
