"""The application and its exit codes: 0 for success; 1 for a negative result; 2 for bad input."""

import os
import sys
from contextlib import suppress
from typing import Any, NoReturn

import click

from narrows.base.aliases import aliases, name_here
from narrows.base.errors import InputError, near_miss, reason, shown
from narrows.base.progress import listening

# Verbs in the order of use; a verb in none of these groups comes last.
GROUPS = {
    "Start": ("demo", "reproduce"),
    "Tests and models": ("estimate", "ships", "plan", "identify", "compare", "explain", "scale"),
    "Voyages": ("waterway", "squat", "simulate", "map", "trials", "linearize"),
    "On board": ("envelope", "learn", "monitor"),
    "Other programs": ("export",),
}


class Verbs(click.Group):
    """The verbs in groups; near names are answered with the right one."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        word = args[0]
        if word == "help":
            args = [*args[1:2], "--help"]
            word = args[0]
            if word == "--help":
                click.echo(ctx.get_help())
                ctx.exit()
        if same := name_here(word.lower(), "verbs"):
            args, word = [same, *args[1:]], same
        if self.get_command(ctx, word) is None and not word.startswith("-"):
            meant = name_here(word.lower(), "other_verbs")
            near = f"; write narrows {meant}" if meant else near_miss(word, self.commands)
            raise InputError(f"there is no verb {shown(word)}{near or '; verbs: ' + ', '.join(self.commands)}")
        name, command, rest = super().resolve_command(ctx, args)
        return name, command, [_option_here(one, command) for one in rest] if command else rest

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        grouped = {verb for verbs in GROUPS.values() for verb in verbs}
        rest = {"More": tuple(verb for verb in self.commands if verb not in grouped)}
        for title, verbs in (GROUPS | rest).items():
            rows = [(verb, self.commands[verb].get_short_help_str(62)) for verb in verbs if verb in self.commands]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


def _option_here(word: str, command: click.Command) -> str:
    """Return an option under its name here: ``--offset`` is ``--y`` where a verb has that one."""
    name, equals, value = word.partition("=")
    known = {option for parameter in command.params for option in parameter.opts}
    plain = name.removeprefix("--").replace("-", "_")
    if name[:2] != "--" or name in known:
        return word
    rows = [*aliases("arguments").items(), *aliases("options").items()]
    groups = [{ours, *theirs} for ours, theirs in rows if plain in (ours, *theirs)]
    same = {f"--{one.replace('_', '-')}" for group in groups for one in group} & known
    if len(same) != 1 and (meant := name_here(plain, "other_options")):
        raise InputError(f"there is no option {name} of narrows {command.name}; {meant}")
    return f"{same.pop()}{equals}{value}" if len(same) == 1 else word


@click.group(
    "narrows",
    cls=Verbs,
    invoke_without_command=True,
    context_settings={"max_content_width": 100, "help_option_names": ["-h", "--help"]},
    epilog="narrows VERB --help shows options and an example; anywhere, --verbose prints all rows and notes, --debug "
    "the traceback of an error.",
)
@click.version_option(package_name="narrows", message="narrows %(version)s")
@click.pass_context
def app(context: click.Context) -> None:
    """Turn captive model tests into a closed-form bank-effect model, with the range in which to trust it."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main() -> NoReturn:
    """Run the command line: bad input is one line on stderr and exit code 2."""
    debug = "--debug" in sys.argv
    arguments = [word for word in sys.argv[1:] if word not in ("--debug", "--verbose")]
    try:
        code = _run(arguments)
        sys.stdout.flush()  # An unwritable output is reported here, not by Python at its end
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
    shows_notes = sys.stderr.isatty() and "--json" not in arguments
    try:
        with listening(lambda sentence: click.echo(sentence, err=True), shows_notes):
            code = app(arguments, "narrows", standalone_mode=False)
    except SystemExit as left:
        code = left.code
    return code if isinstance(code, int) else 0


def _sentence(error: Exception) -> str:
    """Return the message for an error outside the program, nothing for a fault of the program."""
    if isinstance(error, InputError):
        return str(error)
    if hasattr(error, "format_message"):
        message = error.format_message().replace(
            "is not a valid float.", "is not a number; write it as 12.5, or with its unit as 12.5m"
        )
        verb = getattr(error, "ctx", None)
        name, example = (f" {verb.command.name}", verb.command.epilog) if verb and verb.parent else ("", "")
        return f"{message.rstrip('.')}; see narrows{name} --help{example and f'. {example}'}"
    if isinstance(error, OSError | UnicodeEncodeError):
        _silence()
        return f"the output cannot be written ({reason(error)}); send it elsewhere"
    return f"this is {reason(error)}; ask for less" if isinstance(error, MemoryError) else ""


def _silence() -> None:
    """Close standard output that nobody reads any more, also for Python's end."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _leave(sentence: str, code: int) -> NoReturn:
    click.echo(f"narrows: {sentence}", err=True)
    raise SystemExit(code)
