"""What other libraries call the same things: names that are answered, and names for which there is another way."""

from functools import partial
from typing import Any

CALL = "()"
# Names of ours by what is called the same elsewhere; brackets after whatever is called.
SAME = {
    "coefficients": ("params", "coef_", "coef", "popt"),
    "std": ("bse", "stderr", "standard_errors", "std_errors"),
    "covariance": ("pcov", "cov()", "cov_params()"),
    "intervals": ("confidence_intervals", "ci"),
    "residuals": ("resid",),
    "predict()": ("fittedvalues", "fitted"),
    "corr()": ("correlation", "correlation_matrix"),
    "latex()": ("to_latex()", "equations()"),
    "poles()": ("eigenvalues()", "eigvals()"),
    "with_coefficients()": ("replace()", "set_params()", "assign()", "set_coefficients()", "with_values()"),
    "with_parts()": ("replace()",),
    "to_dataframe()": ("df", "to_frame()", "to_pandas()"),
    "save()": ("write()", "dump()", "to_toml()", "to_file()"),
    "t": ("time", "times"),
    "length": ("L", "Lpp"), "beam": ("B",), "draft": ("T",), "block_coefficient": ("Cb",),
}  # fmt: skip
# What does not mean the same, and what is written here instead.
ANOTHER = {
    **dict.fromkeys(("success", "status", "message"), ("outcome",)),
    **dict.fromkeys(("show", "figure"), ("plot()",)),
    **dict.fromkeys(("pvalues", "tvalues", "zvalues"), ("verdicts",)),
    **dict.fromkeys(("aic", "bic", "llf"), ("left_out",)),
    **dict.fromkeys(("heading", "psi_deg", "heading_deg"), ("psi",)),
    **dict.fromkeys(("data", "values_"), ("to_dataframe()",)),
    "tests": ("test(name)",), "speed": ("u",),
}  # fmt: skip


def answer(thing: Any, name: str) -> Any:
    """Return what a thing has under another name, by what that is called elsewhere."""
    known = {*dir(type(thing)), *getattr(type(thing), "__dataclass_fields__", ())}
    for ours, theirs in SAME.items():
        attribute = ours.removesuffix(CALL)
        if attribute in known and (name in theirs or name + CALL in theirs):
            value = getattr(thing, attribute)
            called, calls = name + CALL in theirs, ours.endswith(CALL)
            if called == calls:
                return value
            return partial(getattr, thing, attribute) if called else value()
    remedy = next((it for it in ANOTHER.get(name, ()) if it.partition("(")[0] in known), None)
    if remedy is None:
        return object.__getattribute__(thing, name)
    raise AttributeError(f"a {type(thing).__name__} has no {name!r}; write {remedy}", name=None, obj=None)
