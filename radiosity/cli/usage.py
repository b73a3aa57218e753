"""What is said of a command line that cannot be read, in one message as of all other errors."""

import re
import sys

from typer.exceptions import TyperException


def complaint(error: TyperException) -> str:
    """Return what is wrong with a command line, where, and the way out."""
    verb = _path(error)
    if hasattr(error, "possibilities"):  # the option does not exist
        return f"{error.option_name} is no option of {verb}: {_nearest_option(error)}"
    param = getattr(error, "param", None)
    if param is not None and not error.message:
        return f"{_name(param)} is missing{_what(param)}: see {verb} --help"
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
    return f"radiosity {context.info_name}" if in_verb else "radiosity"


def _name(param) -> str:
    """Return an option as it may be typed, or the argument's name."""
    if param.param_type_name == "argument":
        return param.metavar.strip("[]")
    return " or ".join(param.opts)


def _what(param) -> str:
    return f" ({param.help.rstrip('.')})" if param.help else ""


def _nearest_option(error) -> str:
    from radiosity.scene.checks import nearest  # numpy takes a tenth of a second

    params = error.ctx.command.get_params(error.ctx)
    known = [option for param in params for option in (*param.opts, *param.secondary_opts)]
    like = nearest(error.option_name, known)
    return like if like.startswith("did you mean") else f"see {_path(error)} --help"


def _plain(message: str) -> str:
    """Return a sentence without its full stop and capital, to stand within another one."""
    return message[:1].lower() + message[1:].rstrip(".")
