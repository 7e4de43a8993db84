"""What holds of every picture."""

from matplotlib.figure import Figure
from matplotlib.text import Text


def assert_readable(figure: Figure) -> None:
    """Fail where something of a picture is cut at the edge, or a word smaller than 7 pt."""
    figure.draw_without_rendering()
    drawn, slack = figure.get_tightbbox(), 0.01
    assert min(drawn.x0, drawn.y0) >= -slack
    assert drawn.x1 <= figure.get_figwidth() + slack
    assert drawn.y1 <= figure.get_figheight() + slack
    assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text().strip()) >= 7.0
