"""narrows: from captive model tests to a closed-form bank-effect model that says how far it can be trusted.

The public names are listed in ``__init__.pyi``; each loads when it is first asked for, so that importing the
package costs next to nothing.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
