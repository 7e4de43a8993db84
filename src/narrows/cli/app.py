"""The application, and how it leaves: exit code 0; 1 where it ran and says no; 2 for bad input."""

import os
import sys
from contextlib import suppress
from typing import Annotated, NoReturn

import typer

from narrows.errors import InputError, reason
from narrows.progress import listening

app = typer.Typer(
    name="narrows",
    help="From captive model tests to a closed-form bank-effect model that says how far it can be trusted.",
    epilog="--debug, anywhere, shows the traceback of an error.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from narrows import __version__

        typer.echo(f"narrows {__version__}")
        raise typer.Exit


@app.callback()
def verbs(
    version: Annotated[
        bool, typer.Option("--version", help="Say which version this is.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Keep the verb in the command line even where there is one verb alone."""


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
        with listening(lambda sentence: typer.echo(sentence, err=True), told):
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
    typer.echo(f"narrows: {sentence}", err=True)
    raise SystemExit(code)
