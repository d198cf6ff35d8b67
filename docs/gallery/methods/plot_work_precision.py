"""Error against run time
======================

How long does a given error take? Each pale line is a method with shorter and shorter steps: the
error against the closed form over the processor time of a body. The best of each family has a
colour, and the broad line is the Pareto front. The star is the closed form. The times belong to the
machine that built the page.

How to: :doc:`compare methods on your own problem </methods>`.
"""

import matplotlib.pyplot as plt

import rigid

report = rigid.report(
    rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))),
    omega=[1.0, 1.0, 1.0],
    t_end=20.0,
    methods=["exact", "rk4", "dop853", "taylor16", "splitting4", "dmv10"],
    progress=False,
)
figure, ax = plt.subplots(figsize=(9, 6.5), layout="constrained")
report.plot(ax=ax)

plt.show()
