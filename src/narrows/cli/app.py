"""The application, and how it leaves: exit code 0; 1 where it ran and says no; 2 for bad input."""

import sys
from typing import NoReturn

import typer

from narrows.errors import InputError

app = typer.Typer(
    name="narrows",
    help="From captive model tests to a closed-form bank-effect model that says how far it can be trusted.",
    epilog="--debug, anywhere, shows the traceback of an error.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)


@app.callback()
def verbs() -> None:
    """Keep the verb in the command line even where there is one verb alone."""


def main() -> NoReturn:
    """Run the command line: bad input is one line on stderr and exit code 2."""
    debug = "--debug" in sys.argv
    arguments = [word for word in sys.argv[1:] if word != "--debug"]
    try:
        code = app(arguments, standalone_mode=False)
    except InputError as error:
        if debug:
            raise
        _leave(str(error), 2)
    except KeyboardInterrupt:
        _leave("interrupted", 130)
    except Exception as error:
        if debug or not hasattr(error, "format_message"):
            raise
        _leave(f"{error.format_message()} (see narrows --help)", 2)
    raise SystemExit(code if isinstance(code, int) else 0)


def _leave(sentence: str, code: int) -> NoReturn:
    typer.echo(f"narrows: {sentence}", err=True)
    raise SystemExit(code)
