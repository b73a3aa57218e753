"""``radiosity verify``."""

from dataclasses import asdict
from typing import Annotated

import typer

from radiosity.cli import completion
from radiosity.cli import options as o
from radiosity.cli.answer import print_answer


def verify(
    as_json: o.Json = False,
    suite: Annotated[
        list[str] | None,
        typer.Option(
            "--suite",
            metavar="NAME",
            help="elements, polygons, extremes, obstructed, curved, rooms, limits, cie171, "
            "reflection or colour; if not given, all. Repeatable.",
            autocompletion=completion.suites,
        ),
    ] = None,
) -> None:
    """Compute the built-in closed-form cases; print expected, found, error and time of each.

    Errors and bounds are relative, or absolute where marked abs. Exit code 1 where an error exceeds
    its bound.

    Examples
    --------
    radiosity verify
    radiosity verify --suite rooms --suite colour
    """
    import time

    from radiosity.solve.verification import SUITES, run_suites

    begun, found = time.perf_counter(), []
    checks = run_suites(suite or list(SUITES))
    if not as_json:
        heads = f"{'error':>10}{'bound':>10}{'':5}{'seconds':>9}"
        print(f"{'suite':11}{'case':44}{'expected':>16}{'found':>16}{heads}")
    for check in checks:
        found.append({**asdict(check), "passed": bool(check.passed)})
        if not as_json:
            print(_line(check), flush=True)
    failed, seconds = sum(not check["passed"] for check in found), time.perf_counter() - begun
    if as_json:
        print_answer({"checks": found, "failed": failed, "seconds": seconds})
    else:
        print(f"{failed} failed" if failed else "all within their bounds", end="")
        print(f", {seconds:.1f} s")
    if failed:
        raise typer.Exit(1)


def _line(check) -> str:
    kind = "" if check.relative else " abs"
    return (
        f"{check.suite:11}{check.case[:43]:44}{check.expected:16.10g}{check.found:16.10g}"
        f"{check.error:10.1e}{check.bound:10.1e}{kind:5}{check.seconds:9.3f}"
        f"{'' if check.passed else '  FAILED'}"
    )
