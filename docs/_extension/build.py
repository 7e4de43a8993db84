"""What Sphinx is told: the directive `made`, and what is done before and after the build."""

from typing import Any

from sphinx.application import Sphinx

from _extension import exports, offline, pictures, rooms
from _extension.made import Made


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive `made`, and what is done before and after the build."""
    app.add_directive("made", Made)
    app.connect("builder-inited", lambda app: rooms.write_pages(app.srcdir), priority=400)
    app.connect("builder-inited", lambda app: pictures.draw_all(app.srcdir, not app.tags.has("unrun")), priority=400)
    app.connect("builder-inited", lambda app: exports.write_all(app.srcdir, not app.tags.has("unrun")), priority=400)
    app.connect("autodoc-process-docstring", rooms.keep_constant, priority=400)
    app.connect("autodoc-process-docstring", rooms.describe_numbers, priority=400)
    app.connect("autodoc-process-docstring", rooms.restore_constant, priority=600)
    app.connect("autodoc-skip-member", rooms.of_others)
    app.connect("builder-inited", offline.bring_mathjax)
    app.connect("build-finished", offline.check)
    return {"version": "1", "parallel_read_safe": False, "parallel_write_safe": True}
