"""The directive `made`: a page says what it wants, and gets the text that is made of the package's own tables."""

from typing import ClassVar

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from _extension.makers import MAKERS


class Made(SphinxDirective):
    """Markdown that is made by one of `MAKERS`."""

    required_arguments = 1
    option_spec: ClassVar = {}

    def run(self) -> list[nodes.Node]:
        """Parse the text in the place of the directive, headings included."""
        if self.arguments[0] not in MAKERS:
            raise self.error(f"nothing makes {self.arguments[0]!r}; choose from {', '.join(MAKERS)}")
        return self.parse_text_to_nodes(MAKERS[self.arguments[0]](), allow_section_headings=True)
