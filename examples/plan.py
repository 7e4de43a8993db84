"""The next tests
==============

Which runs of a towing tank determine the bank best: the standard error that each further run leaves.
"""

import narrows as nw

plan = nw.plan_tests(nw.published("mikkelsen2025_dtc").configuration, 6)
print(plan.summary())
picture = plan.plot()
