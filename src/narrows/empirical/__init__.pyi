from .fleet import published as published
from .fleet import ready_ships as ready_ships
from .formulas import with_astern_thrust as with_astern_thrust
from .main_dimensions import estimate_model as estimate_model
