"""The next tests
==============

Which runs of a towing tank determine the bank best: the standard error that each further run leaves.
"""

from matplotlib.figure import Figure

import narrows as nw

plan = nw.plan_tests(nw.published("mikkelsen2025_dtc").configuration, 6)
print(plan.summary())
picture = Figure((4.8, 3.4), layout="constrained")
axes = picture.subplots()
for name, errors in plan.std.items():
    axes.semilogy(range(1, len(errors) + 1), errors, "o-", linewidth=3, label=name)
axes.set(xlabel="runs", ylabel="standard error", title="Each further run determines the bank better")
axes.legend()
