# %% [markdown]
# # The paper's figure from a run
#
# Time of the programs of each scene with the plain and the area-weighted oriented box, and below it the paired ratio with its 95 % interval.
# `RUN` is the folder of a run, from where the notebook is started; `python figure.py RUN FIGURE` draws another one.

# %%
import sys

import matplotlib.pyplot as plt

import bvbench

ARGUMENTS = [] if "ipykernel" in sys.modules else sys.argv[1:]
RUN, FIGURE = (ARGUMENTS + ["results/reference", "figure.png"][len(ARGUMENTS) :])[:2]
run = bvbench.Run(RUN)
times = run.table("program_times").query("program == 'all' and split_axes == 'own'")
boxes = {"obb-vertex": "plain", "obb-area": "area-weighted"}
scenes = sorted(times["scene"].unique())

# %%
figure, (bars, ratios) = plt.subplots(2, 1, height_ratios=[3, 1], sharex=True, figsize=(7, 6), layout="constrained")
for offset, (variant, label) in zip((-0.2, 0.2), boxes.items(), strict=True):
    rows = times.query("variant == @variant").set_index("scene").loc[scenes]
    ms = rows[["total_ns", "total_low_ns", "total_high_ns"]] / 1e6
    whiskers = [ms["total_ns"] - ms["total_low_ns"].clip(lower=0), ms["total_high_ns"] - ms["total_ns"]]
    bars.bar([x + offset for x in range(len(scenes))], ms["total_ns"], 0.4, yerr=whiskers, capsize=4, label=label)
rows = times.query("variant == 'obb-area'").set_index("scene").loc[scenes]
ratios.errorbar(range(len(scenes)), rows["ratio"], [rows["ratio"] - rows["low"], rows["high"] - rows["ratio"]], fmt="o", capsize=4)
ratios.axhline(1, color="grey", linewidth=1)
bars.set_ylabel("time of the programs, ms")
ratios.set_ylabel("area / plain")
ratios.set_xticks(range(len(scenes)), scenes)
bars.legend()
figure.savefig(FIGURE)
print(rows[["ratio", "low", "high"]].round(3))
