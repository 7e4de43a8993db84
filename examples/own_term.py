"""A term of your own
==================

A term of your own goes through identification without a change to the package.

The regressor's arguments say what it needs; here the u r term, which a harmonic-yaw test at several speeds sees
and the paper's table leaves out.
"""

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
# Tests and speeds that were left out say whether the term is worth its place.
picture = nw.compare(tests, [nw.PAPER, table, nw.CROSSFLOW]).plot()
