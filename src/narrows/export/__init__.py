"""Export: a model out of Python, printed from the lines that its voyages are sailed by."""

from narrows.export.writing import write_c as write_c
from narrows.export.writing import write_fmu as write_fmu
from narrows.export.writing import write_javascript as write_javascript
from narrows.export.writing import write_latex as write_latex
from narrows.export.writing import write_page as write_page
from narrows.export.writing import write_python as write_python
