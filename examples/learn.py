"""Learning: the bank from steady legs
===================================

The rudder angle on two straight legs, one to either side, determines the bank moment of an untested ship more closely.
"""

from matplotlib.figure import Figure

import narrows as nw

model = nw.published("estimated_kcs")
held = {"y": [20.0, -20.0], "u [kn]": [8.0, 8.0], "rudder [deg]": [6.0, -5.5], "drift [deg]": [0.4, -0.5]}
learned = nw.learn_steady(model, held, conditions=nw.SteadyConditions(rudder_error_deg=1.0, drift_error_deg=0.2))
print(learned.summary())

table = learned.to_dataframe().loc[["Y_bank", "N_bank"]]
picture = Figure((4.2, 3.0), layout="constrained")
axes = picture.subplots()
for shift, ship, std, label in ((-0.1, model, "prior_std", "before"), (0.1, learned.model, "std", "after two legs")):
    places = [shift, 1.0 + shift]
    values = [ship[name] for name in table.index]
    axes.errorbar(places, values, yerr=1.96 * table[std], fmt="o", linewidth=3, capsize=6, label=label)
axes.axhline(0.0, color="grey", linewidth=0.8)
axes.set(xticks=[0, 1], xticklabels=table.index, ylabel="coefficient [1]", title="Bank coefficients, 95 %")
axes.set_xlim(-0.5, 1.5)
axes.legend()
