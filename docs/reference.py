"""Write docs/cli.md from the command line itself, and docs/json.md from the schemas of --json.

Run it where a verb, an option or a schema has changed: ``python docs/reference.py``.
"""

import json
import re
from pathlib import Path

from typer.main import get_command

from radiosity.cli.main import app
from radiosity.cli.verb import panels, sections

HERE = Path(__file__).resolve().parent
SCHEMAS = Path(__file__).resolve().parent.parent / "radiosity" / "cli" / "schemas"
MADE = "<!-- made by docs/reference.py: edit the source, not this page -->"
OPTION = re.compile(r"(?<![\w`-])(--?[a-z][\w-]*(?: [A-Z]{3,}\b)?)")
JSON = """\
With `--json` a verb prints one object on stdout and nothing else there; remarks and errors go to
stderr. Files that are asked for are written all the same.

- Exit code 0: the verb's answer, as below.
- Exit code 1: the answer too, where there is one that falls short of what was asked (`solve` and
  `probe` with `reached` false or `estimated_error` above `accuracy`, `formfactors` with `error`
  above `accuracy`, `verify` with `failed` above 0).
- No answer (exit codes 2, 3 and 130; 1 where a solver did not converge): the object of
  [error](#error).

Numbers are numbers, with the unit in the name or in the description; what does not exist is `null`.
The tables are made from the [JSON Schemas](https://json-schema.org/draft/2020-12/schema) in
`radiosity/cli/schemas/`, one file a verb; `parts.json` has what they share. No other keys occur.
A later release may add keys, and takes none away."""


def command_line() -> str:
    """Return the page of all verbs and options."""
    main = get_command(app)
    lines = [MADE, "", "# Command line", "", *_described(main, "radiosity")]
    for name, verb in main.commands.items():
        lines += ["", f"## radiosity {name}", "", *_described(verb, f"radiosity {name}")]
    return "\n".join(lines) + "\n"


def _described(command, path) -> list[str]:
    context = command.make_context(path, [], resilient_parsing=True)
    text, *named = sections(command.help)
    usage = " ".join(command.collect_usage_pieces(context))
    lines = ["```text", f"{path} {usage}", "```", "", _prose(text)]
    for panel, records in panels(command, context).items():
        lines += ["", f"{panel}:", "", "| | |", "|---|---|"]
        lines += [f"| `{_cell(name)}` | {_cell(_prose(said))} |" for name, said in records]
    for heading, body in named:
        lines += ["", f"{heading}:", "", "```text", body.strip("\n"), "```"]
    return lines


def _prose(text: str) -> str:
    """Return text with options as code, paragraph by paragraph."""
    return "\n\n".join(OPTION.sub(r"`\1`", " ".join(p.split())) for p in text.split("\n\n"))


def answers() -> str:
    """Return the page of what --json prints."""
    known = {path.stem: json.loads(path.read_text()) for path in sorted(SCHEMAS.glob("*.json"))}
    parts = known.pop("parts")["$defs"]
    lines = [MADE, "", "# What --json prints", "", JSON]
    verbs = [*get_command(app).commands, "error"]
    for name in [verb for verb in verbs if verb in known]:
        lines += ["", f"## {name}", "", _prose(known[name]["title"]) + ".", ""]
        lines += ["| key | type | |", "|---|---|---|", *_rows(known[name], parts, "")]
    return "\n".join(lines) + "\n"


def _rows(schema, parts, prefix) -> list[str]:
    """Return a row for each key of an object, those inside of it below it."""
    rows = []
    for key, said in _inside(schema):
        said = parts[said["$ref"].rpartition("/")[2]] if "$ref" in said else said
        name = f"{prefix}{key}"
        rows.append(f"| `{name}` | {_kind(said)} | {_cell(_prose(said['description']))} |")
        within = said.get("items", said)
        rows += _rows(within, parts, f"{name}[]." if "items" in said else f"{name}.")
    return rows


def _inside(schema) -> list:
    """Return the keys of an object with their schemas; NAME stands for any key."""
    found = list(schema.get("properties", {}).items())
    if isinstance(schema.get("additionalProperties"), dict):
        other = {"description": "Of that name.", **schema["additionalProperties"]}
        found.append(("NAME", other))
    return found


def _kind(schema) -> str:
    kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    return " or ".join(kinds)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


if __name__ == "__main__":
    (HERE / "cli.md").write_text(command_line())
    (HERE / "json.md").write_text(answers())
