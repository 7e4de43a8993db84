"""The equations of a model in LaTeX, with symbols and with numbers."""

from importlib.metadata import version

from narrows.codegen.printers.latex import latex
from narrows.export.rendering import commented
from narrows.model.model import Model


def latex_text(model: Model) -> str:
    """Return the equations of the forces as a piece of LaTeX, for amsmath."""
    about = (model.configuration.ship.name, f"terms {model.terms.name}", model.source.text)
    lines = [f"% {commented(line)}" for line in (*about, f"written by narrows {version('narrows')}") if line]
    for coefficients in (None, model.coefficients):
        lines += ["\\begin{equation}", latex(model.terms, coefficients), "\\end{equation}"]
    return "\n".join(lines) + "\n"
