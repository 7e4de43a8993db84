"""Plan the next tests
===================

Runs of a towing tank that determine the bank best, and the standard error after each.
"""

from matplotlib.figure import Figure

import narrows as nw

plan = nw.plan_tests(nw.published("mikkelsen2025_dtc").configuration, 6)
print(plan.summary())
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for name, errors in plan.std.items():
    axes.semilogy(range(1, len(errors) + 1), errors, "o-", linewidth=3, label=name)
axes.set(xlabel="runs [1]", ylabel="standard error [1]", title="Standard errors of the bank")
axes.legend()
