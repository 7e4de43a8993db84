"""Three water depths
==================

Bank coefficients of the KCS at three water depths, with their intervals and verdicts.
"""

from matplotlib.figure import Figure

import narrows as nw

picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
axes.axhline(0.0, color="black")
for label, tests in nw.measured_tests("kcs").by_condition().items():
    fit = nw.identify(tests)
    ship, canal = tests.configuration.ship, tests.configuration.canal
    print(f"{label}: h/T = {canal.depth / ship.draft:.2f}")
    for name in ("b_bank", "c_bank"):
        low, high = fit.intervals[name]
        print(f"  {name} = {fit.coefficients[name]:+.3f} ({low:+.3f} to {high:+.3f}), {fit.verdicts[name].status}")
    axes.plot([canal.depth / ship.draft] * 2, [low, high], linewidth=8, solid_capstyle="butt")
axes.set(xlabel="depth / draft [1]", ylabel="c_bank [1]", title="Moment of the bank, 95 % intervals")
