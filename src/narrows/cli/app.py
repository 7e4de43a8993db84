"""The application, and how it leaves: exit code 0; 1 where it ran and says no; 2 for bad input."""

import os
import sys
from contextlib import suppress
from typing import NoReturn

import click

from narrows.errors import InputError, reason
from narrows.progress import listening


@click.group(
    "narrows",
    no_args_is_help=True,
    context_settings={"max_content_width": 100},
    epilog="--debug, anywhere, shows the traceback of an error.",
)
@click.version_option(package_name="narrows", message="narrows %(version)s")
def app() -> None:
    """From captive model tests to a closed-form bank-effect model that says how far it can be trusted."""


def main() -> NoReturn:
    """Run the command line: bad input is one line on stderr and exit code 2."""
    debug = "--debug" in sys.argv
    arguments = [word for word in sys.argv[1:] if word != "--debug"]
    try:
        code = _run(arguments)
        sys.stdout.flush()  # What cannot be written is said here, and not by Python when it ends.
    except BrokenPipeError:
        _silence()
        raise SystemExit(1) from None
    except KeyboardInterrupt:
        _leave("interrupted", 130)
    except Exception as error:
        if debug or not (sentence := _sentence(error)):
            raise
        _leave(sentence, 2)
    raise SystemExit(code)


def _run(arguments: list[str]) -> int:
    told = sys.stderr.isatty() and "--json" not in arguments
    try:
        with listening(lambda sentence: click.echo(sentence, err=True), told):
            code = app(arguments, standalone_mode=False)
    except SystemExit as left:
        code = left.code
    return code if isinstance(code, int) else 0


def _sentence(error: Exception) -> str:
    """What to say of an error that is no fault of the program, nothing of one that is."""
    if isinstance(error, InputError):
        return str(error)
    if hasattr(error, "format_message"):
        return f"{error.format_message()} (see narrows --help)"
    if isinstance(error, OSError | UnicodeEncodeError):
        _silence()
        return f"the output cannot be written ({reason(error)}); send it elsewhere"
    return f"this is {reason(error)}; ask for less" if isinstance(error, MemoryError) else ""


def _silence() -> None:
    """Nobody hears standard output any more, Python neither when it ends."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _leave(sentence: str, code: int) -> NoReturn:
    click.echo(f"narrows: {sentence}", err=True)
    raise SystemExit(code)
