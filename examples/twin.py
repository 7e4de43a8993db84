"""Would the tests have found the truth?
=====================================

Would tests like these have found the truth? Run them on a ship whose coefficients are known.
"""

import narrows as nw

truth = nw.published("mikkelsen2025_dtc")
fit = nw.identify(nw.twin(truth, seed=1))
for name, verdict in fit.verdicts.items():
    low, high = fit.intervals[name]
    print(f"{name:7s} true {truth.coefficients[name]:8.2f}   95 % {low:9.2f} to {high:9.2f}   {verdict.status}")

picture = fit.plot()
