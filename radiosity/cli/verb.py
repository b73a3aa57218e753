"""How verbs look: their help in plain text, options in panels, examples as they are typed."""

import re
from textwrap import shorten

from typer.core import TyperCommand, TyperGroup

SECTION = re.compile(r"\n*^(Examples|Exit codes)\n-+\n", re.M)  # of a docstring
LINE = 60  # letters of a help that stands in a line
WIDEST = 100  # columns of help, where the terminal has them


class Verb(TyperCommand):
    """A verb whose help has what it does, its arguments, panels of options, and examples."""

    def collect_usage_pieces(self, ctx) -> list[str]:
        """Return ``SCENE`` for what must be given and ``[POINTS.csv]`` for what may."""
        return [piece.strip("{}") for piece in super().collect_usage_pieces(ctx)]

    def shell_complete(self, ctx, incomplete):
        """Return what may follow, each with a help of one line: shells take more for more words."""
        return in_a_line(super().shell_complete(ctx, incomplete))

    def format_help_text(self, ctx, formatter) -> None:
        """Write the docstring up to its first section."""
        formatter.write_paragraph()
        with formatter.indentation():
            formatter.write_text(sections(self.help)[0])

    def format_options(self, ctx, formatter) -> None:
        """Write arguments and options by panel."""
        for name, records in panels(self, ctx).items():
            with formatter.section(name):
                formatter.write_dl(records)

    def format_epilog(self, ctx, formatter) -> None:
        """Write the docstring's sections as they stand there."""
        write_sections(self.help, formatter)


class Verbs(TyperGroup):
    """The verbs, in the order of the main help; names the nearest one for what is none."""

    def resolve_command(self, ctx, args):
        """Return the verb that is typed, or name the nearest."""
        if args[0] not in self.commands and not ctx.resilient_parsing:  # of completion
            from radiosity.scene.names import nearest

            raise ValueError(f"{args[0]!r} is no verb: {nearest(args[0], self.commands)}")
        return super().resolve_command(ctx, args)

    def format_help_text(self, ctx, formatter) -> None:
        """Write the text up to its first section."""
        Verb.format_help_text(self, ctx, formatter)

    def format_commands(self, ctx, formatter) -> None:
        """Write what each verb does, in a sentence."""
        with formatter.section("Verbs"):
            formatter.write_dl([(name, first(verb.help)) for name, verb in self.commands.items()])

    def shell_complete(self, ctx, incomplete):
        """Return the verbs that may be meant, each with a help of one line."""
        return in_a_line(super().shell_complete(ctx, incomplete))

    def format_epilog(self, ctx, formatter) -> None:
        """Write the sections of the text as they stand there."""
        write_sections(self.help, formatter)


def first(text: str) -> str:
    """Return the first paragraph of a help, without its full stop."""
    return " ".join(text.split("\n\n")[0].split()).rstrip(".")


def in_a_line(items: list) -> list:
    """Return what a shell offers, its help shortened to a line."""
    for item in items:
        item.help = item.help and shorten(item.help, LINE, placeholder=" ..")
    return items


def panels(command, ctx) -> dict[str, list[tuple[str, str]]]:
    """Return arguments, then options by panel, in order: each as it is typed, and its help."""
    found, others = {}, "Options" if isinstance(command, Verbs) else "Running"
    for param in command.get_params(ctx):
        if param.param_type_name == "argument":
            found.setdefault("Arguments", []).append((param.metavar, param.help))
        else:
            found.setdefault(param.rich_help_panel or others, []).append(param.get_help_record(ctx))
    return found


def sections(text: str) -> list:
    """Return the text of a docstring before its sections, then each as ``(name, body)``."""
    before, *parts = SECTION.split(text)
    return [before, *zip(parts[::2], parts[1::2], strict=True)]


def write_sections(text: str, formatter) -> None:
    """Write the sections of a docstring, their lines as they are."""
    for name, body in sections(text)[1:]:
        with formatter.section(name):
            for line in body.strip("\n").splitlines():
                formatter.write(f"{'':{formatter.current_indent}}{line}".rstrip() + "\n")
