from .figures import figure_of as figure_of
from .fit_figures import correlation_figure as correlation_figure
from .fit_figures import forces_figure as forces_figure
from .fit_figures import residuals_figure as residuals_figure
from .fit_page import write_report as write_report
from .voyage_figures import animation_of as animation_of
from .voyage_figures import map_figure as map_figure
