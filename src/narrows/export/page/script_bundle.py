"""ES modules that import each other, as text that stands by itself in a page: each a function that gives its names."""

import re
from collections.abc import Iterator, Mapping
from importlib.resources import files

from narrows.web.assets import asset, without_exports

IMPORT = re.compile(r'^import \{ ([^}]*) \} from "\./([\w/.]+)";\n', re.MULTILINE)
SHARED = re.compile(r'^import \{ ([^}]*) \} from "\.\./\.\./\.\./web/([\w.]+)";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?:(?:async )?function|const|let) (?:(\w+)|\[([^\]]*)\])", re.MULTILINE)
COMMENTS = re.compile(r"^[ \t]*(?://.*|/\*\*.*?\*/)[ \t]*\n", re.MULTILINE)
BLOCK = re.compile(r"/\*\*.*?\*/\n", re.DOTALL)
# Words between quotes, which stay as they are, and signs that need no blank beside them.
SPACED = re.compile(r"""("[^"\n]*"|`[^`]*`)|[ ]*([=*/<>?:,{}();&|]+)[ ]*""")
INDENT = re.compile(r"^[ \t]+", re.MULTILINE)


def bundled(entry: str, given: Mapping[str, str], known: set[str]) -> str:
    """Return a script with all that it imports, in order."""
    return "".join(_modules(entry, given, known))


def _modules(name: str, given: Mapping[str, str], known: set[str]) -> Iterator[str]:
    if name in known:
        return
    known.add(name)
    text = given.get(name) or _read(name)
    for match in (*IMPORT.finditer(text), *SHARED.finditer(text)):
        yield from _modules(match[2], given, known)
    yield _as_function(name, text)


def _read(name: str) -> str:
    path = files("narrows.export.page") / "script" / name
    return path.read_text("utf-8") if path.is_file() else asset(name)


def _as_function(name: str, text: str) -> str:
    exported = [word for match in EXPORT.finditer(text) for word in re.split(r"\W+", match[1] or match[2])]
    body = without_exports(IMPORT.sub(_taken, SHARED.sub(_taken, text)))
    return f"const {_variable(name)} = (() => {{\n{smaller(body)}return {{ {', '.join(exported)} }};\n}})();\n"


def _taken(match: re.Match[str]) -> str:
    return f"const {{ {match[1].replace(' as ', ': ')} }} = {_variable(match[2])};\n"


def _variable(name: str) -> str:
    return f"module_{name.removesuffix('.js')}"


def smaller(text: str) -> str:
    """Return a script or a style without comments, indentation and blanks beside signs."""
    bare = INDENT.sub("", COMMENTS.sub("", BLOCK.sub("", text)))
    return re.sub(r"\n+", "\n", SPACED.sub(lambda match: match[1] or match[2], bare))
