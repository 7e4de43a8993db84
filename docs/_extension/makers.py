"""What a page may ask for, by name: each gives Markdown."""

from collections.abc import Callable

from _extension import commands, glossary, names, registries, schemas, terms

MAKERS: dict[str, Callable[[], str]] = {
    "motion": glossary.motion,
    "particulars": glossary.particulars,
    "forces": glossary.forces,
    "actuators": glossary.actuators,
    "columns": glossary.columns,
    "term-tables": terms.tables,
    "bank-forms": terms.bank_forms,
    "squat-formulas": terms.squat_formulas,
    "public-names": names.text,
    "commands": commands.text,
    "schemas": schemas.text,
    "registries": registries.text,
}
