"""Ships without towing-tank tests: models from main dimensions, and a fleet of available ships."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
