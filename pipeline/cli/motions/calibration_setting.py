"""What options of a calibration say: kinds of parameters that may change, and what is known of them beforehand."""

from pipeline.errors import UsageError

_NUMBERS = ("platform", "offsets", "rails", "lengths", "zeros", "reflectors")
"""Kinds of parameters that a prior deviation without a kind is for: lengths."""


def fitted_kinds(text: str | None) -> tuple[str, ...]:
    """Read the kinds that may change, separated by commas; None: the usual ones.

    Raises
    ------
    UsageError
        When there is no such kind, or none is named.
    """
    from pipeline.calibrate.model.parameters import CHOICES, USUAL

    if text is None:
        return USUAL
    kinds = tuple(part.strip() for part in text.split(",") if part.strip())
    if unknown := [kind for kind in kinds if kind not in CHOICES]:
        raise UsageError(f"--fit: there is no {', '.join(unknown)}; choose from {', '.join(CHOICES)}")
    if not kinds:
        raise UsageError(f"--fit names nothing; choose from {', '.join(CHOICES)}")
    return kinds


def prior_deviations(given: list[str] | None, reflector_std_m: float | None) -> dict[str, float]:
    """Read deviations of what is known: NUMBER for all lengths, KIND=NUMBER for one kind; by the names of kinds.

    Raises
    ------
    UsageError
        When one is something else.
    """
    from pipeline.calibrate.model.parameters import CHOICES

    found: dict[str, float] = {}
    for text in sorted(given or [], key=lambda one: "=" in one):
        kind, _, number = text.rpartition("=")
        try:
            std = float(number)
        except ValueError:
            std = 0.0
        if not 1e-9 <= std <= 0.1 or (kind and kind not in CHOICES):
            raise UsageError(
                f"--prior {text}: expected a number from 1e-9 to 0.1, or KIND=NUMBER, KIND one of {', '.join(CHOICES)}"
            )
        found |= dict.fromkeys([kind] if kind else _NUMBERS, std)
    return found if reflector_std_m is None else {**found, "reflectors": reflector_std_m}
