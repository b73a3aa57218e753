"""``radiosity verify``."""

from typing import Annotated

import typer


def verify(
    suite: Annotated[
        list[str] | None,
        typer.Option(
            "--suite",
            metavar="NAME",
            help="elements, polygons, extremes, obstructed, curved, rooms, limits, cie171, "
            "reflection or colour; all by default.",
        ),
    ] = None,
) -> None:
    """Compute the built-in closed-form cases; print expected, found, error and time.

    Errors and bounds are relative, or absolute where marked. Exit code 1 where an error exceeds
    its bound.
    """
    import time

    from radiosity.solve.verification import SUITES, run_suites

    begun, failed = time.perf_counter(), 0
    checks = run_suites(suite or list(SUITES))
    heads = f"{'error':>10}{'bound':>10}{'':5}{'seconds':>9}"
    print(f"{'suite':11}{'case':44}{'expected':>16}{'found':>16}{heads}")
    for check in checks:
        failed += not check.passed
        print(_line(check), flush=True)
    print(f"{failed} failed" if failed else "all within their bounds", end="")
    print(f", {time.perf_counter() - begun:.1f} s")
    if failed:
        raise typer.Exit(1)


def _line(check) -> str:
    kind = "" if check.relative else " abs"
    return (
        f"{check.suite:11}{check.case[:43]:44}{check.expected:16.10g}{check.found:16.10g}"
        f"{check.error:10.1e}{check.bound:10.1e}{kind:5}{check.seconds:9.3f}"
        f"{'' if check.passed else '  FAILED'}"
    )
