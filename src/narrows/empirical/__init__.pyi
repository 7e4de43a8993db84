from .fleet import published as published
from .fleet import ready_ships as ready_ships
from .main_dimensions import estimate_model as estimate_model
from .propulsion import with_astern_thrust as with_astern_thrust
