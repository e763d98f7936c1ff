"""What can be said about a simulated pass of a forward-scatter radar; what an experiment varies is a number."""

from __future__ import annotations

from algorithms.spec import Parameters, parameter


class PassParameters(Parameters):
    """Site, target, instants, and what is wrong with the Dopplers."""

    base_m: float = parameter(40_000.0, title="Base line", unit="m", symbol="a", group="stations", ge=100, le=1e6)
    """From the middle of the receivers to the transmitter."""
    spacing_m: float = parameter(
        300.0, title="Spacing of the receivers", unit="m", symbol="b", group="stations", ge=1, le=1e5
    )
    """Across the base line; the first receiver stands on the right of who looks at the transmitter."""
    askew_deg: float = parameter(0.0, title="Turn of the receivers", unit="°", group="stations", ge=-80, le=80)
    """The receivers' line is turned by so much, anticlockwise, from the perpendicular to the base line."""
    transmitter_spacing_m: float = parameter(
        0.0, title="Spacing of the transmitters", unit="m", symbol="d", group="stations", ge=0, le=1e5
    )
    """0 = one transmitter; else two of them, whose signals can be told apart, and four Dopplers."""
    one_receiver: bool = parameter(False, title="One receiver", group="stations")
    """A single receiver in the middle: with an azimuth, or with two transmitters."""
    wavelength_m: float = parameter(1.0, title="Wavelength", unit="m", symbol="λ", group="stations", ge=1e-3, le=1e3)
    """Of the transmitter."""
    bearing_deg: float = parameter(90.0, title="Bearing of the base line", unit="°", group="stations", ge=-360, le=360)
    """From the receivers to the transmitter, clockwise from north."""
    crossing_distance_m: float = parameter(
        15_000.0, title="Crossing distance", unit="m", symbol="s", group="targets", ge=10, le=1e6
    )
    """From the receivers to where the target crosses the base line."""
    crossing_time_s: float | None = parameter(
        None, title="Crossing time", unit="s", symbol="τ", group="targets", ge=-1e5, le=1e5
    )
    """Empty = the target begins 3 km beside the base line."""
    speed_mps: float = parameter(200.0, title="Speed", unit="m/s", symbol="v", group="targets", ge=1, le=1e4)
    """At the crossing."""
    course_deg: float = parameter(90.0, title="Course", unit="°", symbol="ψ", group="targets", ge=-180, le=180)
    """From the base line, seen from the receivers; 90 crosses it to the left, -90 to the right."""
    acceleration_mps2: float = parameter(
        0.0, title="Acceleration across", unit="m/s²", symbol="a_y", group="targets", ge=-100, le=100
    )
    """Across the base line."""
    altitude_m: float = parameter(0.0, title="Altitude", unit="m", symbol="H", group="targets", ge=0, le=5e4)
    """Above the plane of the terminals; nobody tells the algorithms."""
    targets: int = parameter(1, title="Targets", unit="1", group="targets", ge=1, le=50)
    """One after another; the receiver does not tell them apart."""
    target_interval_s: float = parameter(
        60.0, title="Interval between targets", unit="s", group="targets", gt=0, le=1e5
    )
    """From one crossing to the next."""
    distance_step_m: float = parameter(0.0, title="Step of the distance", unit="m", group="targets", ge=-1e6, le=1e6)
    """Each target crosses so much further than the one before."""
    period_s: float = parameter(
        1.0, title="Interval of the Dopplers", unit="s", symbol="T", group="timing", ge=1e-3, le=1e4
    )
    """Between two measurements, the first at 0 s."""
    jitter_share: float = parameter(0.0, title="Irregularity", unit="1", group="timing", ge=0, le=0.25)
    """Each instant is moved by up to so much of the interval; the instants are the same in all trials."""
    timing_seed: int = parameter(0, title="Seed of the instants", group="timing", advanced=True, ge=0, le=2**32 - 1)
    """Another seed gives other irregular instants."""
    observed_s: float | None = parameter(None, title="Observed time", unit="s", group="timing", ge=0, le=1e5)
    """Of each target; empty = until it is as far beyond the base line as it began before it."""
    sigma_doppler_hz: float = parameter(
        0.2, title="Doppler error", unit="Hz", symbol="σ_f", group="reception", gt=0, le=1e4
    )
    """Standard deviation of one Doppler, and what the site tells the algorithms."""
    sigma_azimuth_deg: float | None = parameter(
        0.5, title="Azimuth error", unit="°", symbol="σ_φ", group="reception", gt=0, le=45
    )
    """Standard deviation of the azimuth that the first receiver measures; empty = no azimuths."""
    sigma_elevation_deg: float | None = parameter(
        None, title="Elevation error", unit="°", symbol="σ_ε", group="reception", gt=0, le=45
    )
    """Standard deviation; empty = no elevations."""
    sigma_doppler_rate_hz_s: float | None = parameter(
        None, title="Frequency-rate error", unit="Hz/s", group="reception", gt=0, le=1e4
    )
    """Standard deviation; empty = no measured frequency rates."""
    false_share: float = parameter(0.0, title="False Dopplers", unit="1", group="reception", ge=0, le=1)
    """Share of Dopplers in whose place anything within the band comes."""
    false_band_hz: float = parameter(100.0, title="Band of false Dopplers", unit="Hz", group="reception", gt=0, le=1e6)
    """False ones are uniform from minus to plus this."""
    missing_share: float = parameter(0.0, title="Missing Dopplers", unit="1", group="reception", ge=0, le=1)
    """Share of Dopplers that are not measured, of each receiver by itself."""
    blind_zone_hz: float = parameter(0.0, title="Blind zone", unit="Hz", symbol="F", group="reception", ge=0, le=1e5)
    """Smaller Dopplers are not measured: the receiver cannot tell them from the carrier."""
    unsigned: bool = parameter(False, title="Doppler without sign", group="reception")
    """The receiver gives magnitudes only."""
    clock_error_ms: float = parameter(0.0, title="Clock error", unit="ms", group="reception", ge=-1e4, le=1e4)
    """By how much the second receiver's clock is late: it stamps its Dopplers too early."""
    frequency_offset_hz: float = parameter(0.0, title="Frequency offset", unit="Hz", group="reception", ge=-1e4, le=1e4)
    """Added to the second receiver's Doppler."""
    common_offset_hz: float = parameter(0.0, title="Common offset", unit="Hz", group="reception", ge=-1e4, le=1e4)
    """Added to all Dopplers."""
    spacing_error_percent: float = parameter(
        0.0, title="Error of the spacing", unit="%", group="reception", ge=-50, le=50
    )
    """By how much the site tells a larger spacing."""
    base_error_percent: float = parameter(
        0.0, title="Error of the base line", unit="%", group="reception", ge=-50, le=50
    )
    """By how much the site tells a longer base line."""
    wavelength_error_percent: float = parameter(
        0.0, title="Error of the wavelength", unit="%", group="reception", ge=-50, le=50
    )
    """By how much the site tells a longer wavelength."""
    instants_s: tuple[float, ...] = parameter(
        (9.0, 12.0, 16.0, 20.0, 30.0), title="Instants", unit="s", group="legs", max_length=50
    )
    """Metrics are given apart at these instants, and at the crossing and the end."""
