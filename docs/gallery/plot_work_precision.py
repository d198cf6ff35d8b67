"""Error against run time
======================

What an error costs: each line is a method with ever shorter steps, its error against the closed
form and the processor time of a body. High orders are steep, low ones soon too slow; the closed
form itself stands at the lower left, as a star. Times are those of the machine that made the page.
"""

import matplotlib.pyplot as plt

import rigid

report = rigid.report(
    rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))),
    omega=[1.0, 1.0, 1.0],
    t_end=20.0,
    methods=["exact", "rk4", "dop853", "taylor16", "splitting4", "dmv4"],
    progress=False,
)
figure, ax = plt.subplots(figsize=(9, 6.5), layout="constrained")
report.plot(ax=ax)

plt.show()
