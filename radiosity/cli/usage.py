"""What is said of a command line that cannot be read, in one message as of all other errors."""

import re
import sys

from typer.exceptions import TyperException

ALIKE = 0.7  # of 1: options less like one that is typed are not meant


def complaint(error: TyperException) -> str:
    """Return what is wrong with a command line, where, and the way out."""
    verb = _path(error)
    if hasattr(error, "possibilities"):  # the option does not exist
        return f"{error.option_name} is no option of {verb}: {_nearest_option(error)}"
    param = getattr(error, "param", None)
    if param is not None and not error.message:
        return f"{_name(param)} is missing{_what(param)}, see {verb} --help"
    if param is not None:
        return f"{_name(param)} {error.message}"
    return f"{_plain(error.message)}: see {verb} --help"


def as_typed(message: str) -> str:
    """Return a message on ``NAME = VALUE`` with NAME as the option that was typed, if it was."""
    match = re.match(r"(\w+) = ", message)
    option = match and "--" + match[1].replace("_", "-")
    if not match or not any(word.split("=")[0] == option for word in sys.argv[1:]):
        return message
    return f"{option} {message[match.end() :]}"


def _path(error) -> str:
    """Return the verb that was typed, with the program."""
    context = getattr(error, "ctx", None)
    in_verb = context is not None and context.parent is not None
    if in_verb:
        return f"radiosity {context.info_name}"
    return "radiosity" if context else "radiosity VERB"


def _name(param) -> str:
    """Return an option as it may be typed, or the argument's name."""
    if param.param_type_name == "argument":
        return param.metavar.strip("[]")
    short = len(param.opts[0]) == 2
    return "/".join(param.opts) if short else param.opts[0]


def _what(param) -> str:
    """Return what an option that must be given is for; arguments are named for what they are."""
    return "" if param.param_type_name == "argument" else f": {param.help.rstrip('.')}"


def _nearest_option(error) -> str:
    """Return a question with the option that is meant, or where all of them are told."""
    from difflib import get_close_matches

    params = error.ctx.command.get_params(error.ctx)
    known = [option for param in params for option in (*param.opts, *param.secondary_opts)]
    like = get_close_matches(error.option_name, known, 1, ALIKE)
    return f"did you mean {like[0]}?" if like else f"see {_path(error)} --help"


def _plain(message: str) -> str:
    """Return a sentence without its full stop and capital, to stand within another one."""
    message = re.sub(r"^Option '([^']+)'", r"\1", message)
    return message[:1].lower() + message[1:].rstrip(".")
