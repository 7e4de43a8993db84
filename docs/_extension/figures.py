"""What the gallery shows: the figures that an example keeps under a name, each once."""

from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

SHOWN = "_figures_shown"


def figures_of_block(block: tuple[Any, ...], variables: dict[str, Any], settings: dict[str, Any]) -> str:
    """Save the figures that are new since the last block, and return the text that shows them."""
    known = variables["example_globals"]
    shown: list[Figure] = known.setdefault(SHOWN, [])
    paths = []
    for figure in [value for value in known.values() if isinstance(value, Figure)]:
        if not any(figure is other for other in shown):
            shown.append(figure)
            paths.append(next(variables["image_path_iterator"]))
            figure.savefig(paths[-1], dpi=130)
    return figure_rst(paths, settings["src_dir"])
