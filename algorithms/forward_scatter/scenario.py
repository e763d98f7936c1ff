"""The preset from which forward-scatter recordings are simulated (specification 8)."""

from __future__ import annotations

from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import legs_of, simulate
from algorithms.spec import Reference, Scenario

SCENARIOS = (
    Scenario(
        name="forward_scatter_pass",
        title="Pass through the base line",
        summary="A target crosses the base line of a transmitter and two receivers 300 m apart, 15 km from them; 31 "
        "pairs of Dopplers, one a second.",
        family="forward_scatter",
        kind="doppler_pairs",
        parameters=PassParameters,
        simulate=simulate,
        legs=legs_of,
        references=(Reference("scatter2014", "figs. 2-4"),),
    ),
)
