"""Parameters that the forward-scatter algorithms share, each declared once."""

from __future__ import annotations

from typing import Literal

from algorithms.spec import Parameters, parameter

SIGMA_DOPPLER_HZ = 0.2
# A silence longer than so many median intervals ends a pass.
GAP_INTERVALS = 20.0
# Parameters that widen the predicted errors and change no estimate.
CALIBRATION = (
    "sigma_clock_ms",
    "sigma_frequency_offset_hz",
    "sigma_spacing_percent",
    "sigma_base_percent",
    "sigma_wavelength_percent",
)


class ScatterParameters(Parameters):
    """What describes the measurement, and how a recording is cut into passes."""

    sigma_doppler_hz: float | None = parameter(
        None,
        title="Doppler error",
        unit="Hz",
        symbol="σ_f",
        gt=0,
        le=1e5,
        from_site="sigma_doppler_hz",
        fallback=SIGMA_DOPPLER_HZ,
    )
    """Standard deviation of one Doppler frequency. Empty = the site's value."""
    wavelength_m: float | None = parameter(
        None, title="Wavelength", unit="m", symbol="λ", ge=1e-4, le=1e4, from_site="wavelength_m"
    )
    """Empty = the site's value; one of the two is needed."""
    altitude_m: float = parameter(0.0, title="Known altitude", unit="m", symbol="H", ge=-1e3, le=5e4)
    """Height of the target above the plane of the receivers; two receivers cannot measure it."""
    unsigned: bool = parameter(False, title="Doppler without sign", advanced=True)
    """The receiver gives magnitudes only: the sign switch is where it makes the best falling line."""
    passes: Literal["auto", "one"] = parameter(
        "auto",
        title="Passes",
        group="association",
        choices={
            "auto": "cut at silences and where the Dopplers jump up again",
            "one": "the whole recording is one pass",
        },
    )
    """How a recording is cut into passes of one target each."""
    gap_s: float | None = parameter(
        None, title="Gap between passes", unit="s", group="association", advanced=True, gt=0, le=1e6
    )
    """A silence longer than this ends a pass. Empty = twenty median intervals."""
    sigma_clock_ms: float = parameter(0.0, title="Error of the clocks", unit="ms", advanced=True, ge=0, le=1e4)
    """Standard deviation between the clocks of the two receivers; it widens the predicted errors."""
    sigma_frequency_offset_hz: float = parameter(
        0.0, title="Error of the carriers", unit="Hz", advanced=True, ge=0, le=1e4
    )
    """Standard deviation of the frequency offset between the two receivers; it widens the predicted errors."""
    sigma_spacing_percent: float = parameter(0.0, title="Error of the spacing", unit="%", advanced=True, ge=0, le=50)
    """Standard deviation of the told spacing of the receivers; it widens the predicted errors."""
    sigma_base_percent: float = parameter(0.0, title="Error of the base line", unit="%", advanced=True, ge=0, le=50)
    """Standard deviation of the told length of the base line; it widens the predicted errors."""
    sigma_wavelength_percent: float = parameter(
        0.0, title="Error of the wavelength", unit="%", advanced=True, ge=0, le=50
    )
    """Standard deviation of the told wavelength; it widens the predicted errors."""


class FreezeParameters(Parameters):
    """How the windows are fitted and when a crossing is kept."""

    window: int = parameter(10, title="Window", unit="1", symbol="N", group="motion", ge=2, le=500)
    """So many epochs at the end of the data make a line."""
    freeze_rule: Literal["a", "b", "c", "none"] = parameter(
        "a",
        title="Crossing is kept",
        group="motion",
        choices={
            "a": "each receiver: its first value that is past",
            "b": "each receiver: its last value before that",
            "c": "both together, when both are past",
            "none": "never",
        },
    )
    """Which value of the crossing time is kept for ever."""
    freeze_delay: int = parameter(0, title="Delay of keeping", unit="1", group="motion", advanced=True, ge=0, le=250)
    """The value is taken so many epochs after the crossing was seen; half a window less one centres it."""
    confirm: int = parameter(1, title="Windows that confirm", unit="1", group="motion", advanced=True, ge=1, le=50)
    """A crossing counts where so many windows in a row show it; 3 with robust lines keeps false ones out."""
    sigma_doppler_rate_hz_s: float | None = parameter(
        None, title="Frequency-rate error", unit="Hz/s", advanced=True, gt=0, le=1e5
    )
    """Standard deviation of a measured frequency rate. Empty = measured rates take the place of the slopes."""
    robust: Literal["none", "huber", "consensus"] = parameter(
        "none",
        title="False values",
        group="association",
        choices={
            "none": "least squares",
            "huber": "large residuals weigh less",
            "consensus": "what most values agree on",
        },
    )
    """How false Dopplers are kept out; confirm with three windows then."""
