"""``radiosity verify``."""

from typing import Annotated

import typer


def verify(
    suite: Annotated[
        list[str] | None,
        typer.Option(
            "--suite", metavar="NAME", help="elements, polygons or rooms; all by default."
        ),
    ] = None,
) -> None:
    """Compute the built-in closed-form cases; print expected, found, error and time.

    Exit code 1 where an error exceeds its bound.
    """
    from radiosity.solve.verification import SUITES, run_suites

    checks, failed = run_suites(suite or list(SUITES)), 0
    print(f"{'case':44}{'expected':>16}{'found':>16}{'error':>10}{'bound':>10}{'seconds':>9}")
    for check in checks:
        bad = not check.error <= check.bound
        failed += bad
        print(
            f"{check.case[:43]:44}{check.expected:16.10g}{check.found:16.10g}"
            f"{check.error:10.1e}{check.bound:10.1e}{check.seconds:9.3f}{'  FAILED' * bad}"
        )
    print(f"{failed} failed" if failed else "all within their bounds")
    if failed:
        raise typer.Exit(1)
