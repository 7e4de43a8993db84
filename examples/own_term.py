"""A term of your own
==================

Identification accepts a term of your own without a change to the package.

The arguments of the regressor are the columns that it needs; here the u r term, which the paper's table leaves out.
"""

from matplotlib.figure import Figure

import narrows as nw


def turning_ahead(u, r):
    return -u * r


MASS = nw.Dimension(mass=1)
MOMENT = nw.Dimension(mass=1, length=1)

table = nw.PAPER.with_terms(
    "paper with u r",
    sway=[nw.Term("b_ur", "b_{ur}", turning_ahead, MASS)],
    yaw=[nw.Term("c_ur", "c_{ur}", turning_ahead, MOMENT)],
)

tests = nw.measured_tests("kcs").by_condition()["C0101A01"]
for terms in (nw.PAPER, table):
    fit = nw.identify(tests, terms)
    print(f"{terms.name:15s} b_bank = {fit.coefficients['b_bank']:.3f}, R2 of Y left out = {fit.left_out['Y'].r2:.3f}")

# %%
# The errors on left-out tests decide whether the term stays.
compared = nw.compare(tests, [nw.PAPER, table, nw.CROSSFLOW])
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
axes.bar(list(compared.fits), [fit.left_out["Y"].rmse for fit in compared.fits.values()], color="tab:blue")
axes.set(ylabel="error of left-out Y [N]", title="Three tables of terms")
