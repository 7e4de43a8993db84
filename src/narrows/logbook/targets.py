"""Which coefficients a record is to tell."""

from narrows.errors import InputError, did_you_mean, shown
from narrows.model.model import Model


def learnable(model: Model, targets: object) -> tuple[str, ...]:
    """Return the coefficients that matter: those that were named, or those of the bank."""
    names = (targets,) if isinstance(targets, str) else targets
    if not isinstance(names, tuple | list):
        raise InputError(f"targets = {shown(targets)}: give names of coefficients")
    for name in names:
        if not isinstance(name, str) or name not in model.terms.names:
            hint = did_you_mean(name, model.terms.names) if isinstance(name, str) else "; give a name"
            raise InputError(f"there is no coefficient {shown(name)}{hint}")
    names = tuple(names) or tuple(term.name for term in model.terms.terms if term.from_bank)
    if not names:
        raise InputError("this model has no terms of the bank to learn; name the coefficients that matter as targets")
    return names
