"""Three water depths
==================

Bank coefficients of the KCS at three water depths, with their intervals and what is to be said of them.
"""

import narrows as nw

for label, tests in nw.measured_tests("kcs").by_condition().items():
    fit = nw.identify(tests)
    ship, canal = tests.configuration.ship, tests.configuration.canal
    print(f"{label}: h/T = {canal.depth / ship.draft:.2f}")
    for name in ("b_bank", "c_bank"):
        low, high = fit.intervals[name]
        print(f"  {name} = {fit.coefficients[name]:+.3f} ({low:+.3f} to {high:+.3f}), {fit.verdicts[name].status}")

# %%
# All coefficients of the last of them, each with its interval.
picture = fit.plot()
