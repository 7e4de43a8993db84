"""Export: a model out of Python, printed from the lines that its voyages are sailed by."""

from typing import TYPE_CHECKING

from narrows.export.exporters import EXPORTERS

if TYPE_CHECKING:  # For editors and type checkers; at run time every exporter brings its own.
    from narrows.export.exporters.to_bank_force import write_bank_force as write_bank_force
    from narrows.export.exporters.to_c import write_c as write_c
    from narrows.export.exporters.to_fmu import write_fmu as write_fmu
    from narrows.export.exporters.to_javascript import write_javascript as write_javascript
    from narrows.export.exporters.to_latex import write_latex as write_latex
    from narrows.export.exporters.to_matlab import write_matlab as write_matlab
    from narrows.export.exporters.to_page import write_page as write_page
    from narrows.export.exporters.to_python import write_python as write_python

globals().update({own.write.__name__: own.write for own in EXPORTERS.values()})
__all__ = ["EXPORTERS", *sorted(own.write.__name__ for own in EXPORTERS.values())]
