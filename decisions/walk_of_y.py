"""How far a number walks through the package, and how many arrows there are between its rooms.

    python decisions/walk_of_y.py [REVISION ...]      # HEAD unless given; 9af35d2 is where issue 10 began

The walk of y, the offset from the centreline, has three legs: from a cell of a CSV file to the interval of b_bank, to
a grounding, and to the chart of the safe envelope. Each leg is a verb of the command line and the stations that y
calls at, found by marks that do not change when files move and functions are renamed (``LEGS``).

The graph is read from the source alone. Its nodes are what a module defines at its top, and the methods of its classes.
A node has an edge to every definition that it names, be it called or handed on: through imports (those of ``__init__``
files and their stubs too), in its own module, as ``self.name``, and as ``.name`` to the methods of that name in the
nearest classes, those that its module defines or imports, else those that the modules it imports from do, and so on.
Text that is generated and then run is not seen: there the walk goes to the function that runs it. Nor is seen what a
regressor calls.

The walk is the union of the shortest chains of edges from the verb to each station. Its files are the files on it; its
returns are the functions on it that return or yield a value, for each hands on what came of y to the one above.

Rooms are the folders and modules directly under ``src/narrows``; an arrow is a pair of rooms one of which imports the
other, anywhere and for whatever reason, counted once.
"""

import ast
import io
import subprocess
import sys
import tarfile
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache, partial

PACKAGE = "narrows"
OF_BUILTINS = {name for kind in (dict, list, set, str, tuple, float) for name in dir(kind)}
Definition = ast.FunctionDef | ast.ClassDef | ast.Assign | ast.AnnAssign


@dataclass
class Node:
    """A definition: its module, its path inside the package, its syntax tree, and the class that it is a method of."""

    module: str
    tree: Definition
    owner: str = ""

    def hands_on(self) -> bool:
        """Whether it is a function that returns or yields a value."""
        if not isinstance(self.tree, ast.FunctionDef):
            return False
        inner = ast.walk(self.tree)
        return any(isinstance(own, ast.Return | ast.Yield | ast.YieldFrom) and own.value for own in inner)

    def calls(self) -> Iterator[str]:
        """The last name of everything that it calls."""
        for own in (part.func for part in ast.walk(self.tree) if isinstance(part, ast.Call)):
            yield own.id if isinstance(own, ast.Name) else getattr(own, "attr", "")

    def says(self) -> Iterator[str]:
        """Every string in it."""
        own = (part.value for part in ast.walk(self.tree) if isinstance(part, ast.Constant))
        yield from (value for value in own if isinstance(value, str))


Mark = Callable[[str, Node], bool]


def defined_as(names: tuple[str, ...], path: str, node: Node) -> bool:
    """Mark of a definition by its own name: as it was called at one revision or another."""
    return path.rpartition(".")[2] in names


def calling(name: str, path: str, node: Node) -> bool:
    """Mark of a function that calls something."""
    return isinstance(node.tree, ast.FunctionDef) and name in node.calls()


def saying(word: str, path: str, node: Node) -> bool:
    """Mark of a function with a word in a string of its own."""
    return isinstance(node.tree, ast.FunctionDef) and any(word in said for said in node.says())


LEGS: dict[str, tuple[str, dict[str, Mark]]] = {
    "to the interval of b_bank": (
        "identify",
        {
            "a cell is read": partial(calling, "read_csv"),
            "a regressor is evaluated": partial(calling, "regressor"),
            "least squares": partial(calling, "lsq_linear"),
            "an interval": partial(defined_as, ("bounded_interval",)),
        },
    ),
    "to a grounding": (
        "simulate",
        {
            "a step is taken": partial(defined_as, ("rk4_step", "stepped")),
            "the outcome": partial(calling, "Outcome"),
            "its sentence": partial(saying, "Grounded"),
        },
    ),
    "to the chart": (
        "envelope",
        {
            "the trials": partial(defined_as, ("trials",)),
            "a kernel is run": partial(defined_as, ("helmed", "ended")),
            "the chart": partial(defined_as, ("envelope_chart", "plot")),
        },
    ),
}


@dataclass(eq=False)
class Source:
    """The package at a revision: its modules, what they define, and what each name in a module stands for."""

    modules: dict[str, ast.Module] = field(default_factory=dict)
    nodes: dict[str, Node] = field(default_factory=dict)
    aliases: dict[str, dict[str, str]] = field(default_factory=dict)

    @classmethod
    def of(cls, revision: str) -> "Source":
        """Read a revision out of git."""
        archive = subprocess.run(["git", "archive", revision, f"src/{PACKAGE}"], capture_output=True, check=True).stdout
        source = cls()
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            for member in sorted(files.getmembers(), key=lambda own: own.name):
                if member.name.endswith((".py", ".pyi")) and (file := files.extractfile(member)):
                    source.add(member.name.removeprefix("src/"), ast.parse(file.read()))
        return source

    def add(self, path: str, tree: ast.Module) -> None:
        """Take in a file; a stub adds to the names of the file that it stands beside."""
        name = path.rpartition(".")[0].replace("/", ".").removesuffix(".__init__")
        package = name if "__init__" in path else name.rpartition(".")[0]
        self.modules.setdefault(name, ast.Module([], [])).body += tree.body
        own = self.aliases.setdefault(name, {})
        for imported in (each for each in ast.walk(tree) if isinstance(each, ast.ImportFrom | ast.Import)):
            own |= _aliases(imported, package)
        for definition in tree.body:
            for word in _words(definition):
                self.nodes[f"{name}.{word}"] = Node(name, definition)  # type: ignore[arg-type]
                own[word] = f"{name}.{word}"
            if isinstance(definition, ast.ClassDef):
                for method in (each for each in definition.body if isinstance(each, ast.FunctionDef)):
                    self.nodes[f"{name}.{definition.name}.{method.name}"] = Node(name, method, definition.name)

    def resolved(self, path: str) -> str:
        """Follow a name through the files that only hand it on."""
        for _ in range(9):
            module, _, word = path.rpartition(".")
            if path in self.nodes or word not in self.aliases.get(module, {}):
                break
            path = self.aliases[module][word]
        return path

    def edges(self) -> dict[str, set[str]]:
        """What each definition names."""
        return {path: set(self._named(node)) - {path} for path, node in self.nodes.items()}

    def _named(self, node: Node) -> Iterator[str]:
        own = self.aliases[node.module]
        for part in (each for body in _own_part(node.tree) for each in ast.walk(body)):
            if isinstance(part, ast.Name):
                targets = [self.resolved(own.get(part.id, ""))]
            elif isinstance(part, ast.Attribute):
                targets = self._attribute(part, node)
            else:
                continue
            for target in (each for each in targets if each in self.nodes):
                yield target
                yield from (f"{target}.{m}" for m in ("__init__", "__post_init__") if f"{target}.{m}" in self.nodes)

    def _attribute(self, part: ast.Attribute, node: Node) -> list[str]:
        if isinstance(part.value, ast.Name):
            base = self.aliases[node.module].get(part.value.id, "")
            base = f"{node.module}.{node.owner}" if part.value.id == "self" else base
            found = self.resolved(f"{base}.{part.attr}")
            if found in self.nodes:
                return [found]
        return [] if part.attr in OF_BUILTINS else self._nearest(part.attr, node.module)

    @cache  # noqa: B019 - a source lives as long as the script
    def _nearest(self, method: str, module: str) -> list[str]:
        """The methods of a name in the nearest classes that have one."""
        seen: set[str] = set()
        layer = {module}
        while layer:
            known = {self.resolved(path) for own in layer for path in self.aliases.get(own, {}).values()}
            if found := sorted(f"{path}.{method}" for path in known if f"{path}.{method}" in self.nodes):
                return found
            seen |= layer
            layer = {self.nodes[path].module for path in known if path in self.nodes} - seen
        return []


def _words(definition: ast.stmt) -> Iterator[str]:
    """The names that a statement at the top of a module defines."""
    if isinstance(definition, ast.FunctionDef | ast.ClassDef):
        yield definition.name
    elif isinstance(definition, ast.Assign | ast.AnnAssign):
        targets = definition.targets if isinstance(definition, ast.Assign) else [definition.target]
        yield from (own.id for target in targets for own in ast.walk(target) if isinstance(own, ast.Name))


def _own_part(tree: ast.AST) -> list[ast.AST]:
    """What belongs to a definition itself: of a class all but its methods, which are definitions of their own."""
    if not isinstance(tree, ast.ClassDef):
        return [tree]
    return [*tree.bases, *tree.decorator_list, *(own for own in tree.body if not isinstance(own, ast.FunctionDef))]


def _aliases(imported: ast.ImportFrom | ast.Import, package: str) -> dict[str, str]:
    """What each imported name stands for, as a path inside the package."""
    if isinstance(imported, ast.Import):
        return {own.asname or own.name: own.name for own in imported.names}
    above = package.split(".")[: len(package.split(".")) - imported.level + 1] if imported.level else []
    origin = ".".join([*above, *filter(None, [imported.module])])
    return {own.asname or own.name: f"{origin}.{own.name}" for own in imported.names}


def chains(edges: dict[str, set[str]], start: str) -> dict[str, str]:
    """Every definition that can be reached, and the one before it on a shortest chain."""
    before, queue = {start: ""}, deque([start])
    while queue:
        here = queue.popleft()
        for there in sorted(edges[here] - before.keys()):
            before[there] = here
            queue.append(there)
    return before


def walk(source: Source, edges: dict[str, set[str]], verb: str, stations: dict[str, Mark]) -> dict[str, list[str]]:
    """The chain from a verb to each of its stations; empty where none is found."""
    (start,) = (path for path in source.nodes if path.startswith(f"{PACKAGE}.cli") and path.endswith(f".{verb}"))
    before = chains(edges, start)
    found = {}
    for station, mark in stations.items():
        chain, here = [], next((path for path in before if mark(path, source.nodes[path])), "")
        while here:
            chain, here = [here, *chain], before[here]
        found[station] = chain
    return found


def arrows(source: Source) -> set[tuple[str, str]]:
    """The pairs of rooms, the first of which imports the second."""
    found = set()
    for module, aliases in source.aliases.items():
        room = module.split(".")[1:2]
        targets = {path.split(".")[1] for path in aliases.values() if path.startswith(f"{PACKAGE}.")}
        found |= {(room[0], target) for target in targets if room and target != room[0]}
    return found


def measure(revision: str, shown: bool) -> None:
    """Print the counts of one revision; with the chains where they are asked for."""
    source = Source.of(revision)
    edges, everything = source.edges(), set()
    print(revision)
    for leg, (verb, stations) in LEGS.items():
        found = walk(source, edges, verb, stations)
        passed = {path for chain in found.values() for path in chain}
        everything |= passed
        print(f"  {leg}: {counted(source, passed)}")
        for station, chain in found.items():
            if shown or not chain:
                print(f"    {station}: {' > '.join(chain).replace(f'{PACKAGE}.', '') or 'NOT FOUND'}")
    pairs = arrows(source)
    print(f"  in all: {counted(source, everything)}\n  arrows between rooms: {len(pairs)}")
    if shown:
        for room in sorted({first for first, _ in pairs}):
            print(f"    {room} > {', '.join(sorted(second for first, second in pairs if first == room))}")


def counted(source: Source, passed: set[str]) -> str:
    """Say how many files and returns there are among some definitions."""
    files = {source.nodes[path].module for path in passed}
    return f"{len(files)} files, {sum(source.nodes[path].hands_on() for path in passed)} returns"


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--shown"]
    for revision in words or ["HEAD"]:
        measure(revision, "--shown" in sys.argv)
