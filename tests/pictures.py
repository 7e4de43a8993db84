"""What holds of every picture."""

from matplotlib.figure import Figure
from matplotlib.text import Text


def assert_readable(figure: Figure) -> None:
    """Fail where something of a picture is cut at the edge, a word is smaller than 7 pt, or labels overlap."""
    figure.draw_without_rendering()
    drawn, slack = figure.get_tightbbox(), 0.01
    assert min(drawn.x0, drawn.y0) >= -slack
    assert drawn.x1 <= figure.get_figwidth() + slack
    assert drawn.y1 <= figure.get_figheight() + slack
    assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text().strip()) >= 7.0
    labels = [label for one in figure.axes for label in (one.xaxis.label, one.yaxis.label) if label.get_text()]
    headings = [text for one in (figure, *figure.axes) for text in one.texts if text.get_text().strip()]
    headings += [one._left_title for one in figure.axes if one._left_title.get_text().strip()]
    for label in labels:
        others = [text for text in (*labels, *headings) if text is not label]
        over = [text.get_text() for text in others if label.get_window_extent().overlaps(text.get_window_extent())]
        assert not over, label.get_text()
