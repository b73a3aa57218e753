"""Numbers with as many digits as their errors leave sense to."""

from math import floor, isfinite, log10

DIGITS = 4  # where no error is known


def measured(value: float, error: float) -> str:
    """Return a value and its error, rounded alike: the error to one digit, to two if that is 1.

    Examples
    --------
    >>> measured(312.437, 4.21), measured(0.61234, 0.0123), measured(2258.71, 0.0)
    ('312 ± 4', '0.612 ± 0.012', '2259 ± 0')
    >>> measured(1234.5, 87.0), measured(float("nan"), 0.0), measured(3e-7, 2e-8)
    ('1230 ± 90', '-', '3.0e-07 ± 2e-08')
    """
    if not (isfinite(value) and isfinite(error)):
        return "-" if not isfinite(value) else f"{plain(value)} ± ?"
    if error <= 1e-12 * abs(value):
        return f"{plain(value)} ± 0"
    place = _place(error)
    if max(abs(value), error) < 1e-4:
        power = floor(log10(max(abs(value), error)))
        return f"{value:.{max(power - place, 0)}e} ± {error:.0e}"
    return f"{_rounded(value, place)} ± {_rounded(error, place)}"


def rounded(value: float, error: float) -> str:
    """Return a value alone, rounded to what its error leaves.

    Examples
    --------
    >>> rounded(312.437, 4.21), rounded(0.61234, 0.0123)
    ('312', '0.612')
    """
    return measured(value, error).split(" ")[0]


def plain(value: float) -> str:
    """Return a number of which no error is known.

    Examples
    --------
    >>> plain(12.34567), plain(123456.0), plain(0.0), plain(None)
    ('12.35', '123456', '0', '-')
    """
    if value is None or not isfinite(value):
        return "-"
    return f"{value:.0f}" if 10**DIGITS <= abs(value) < 1e9 else f"{value:.{DIGITS}g}"


def _place(error) -> int:
    """Return the power of ten of the last digit that an error leaves."""
    power = floor(log10(error))
    return power - 1 if round(error / 10.0**power, 1) < 2.0 else power


def _rounded(value, place) -> str:
    return f"{round(value, -place) + 0.0:.{max(-place, 0)}f}"
