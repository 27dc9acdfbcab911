"""A case from a dictionary, watched as it is solved, and its fields as dolfinx functions."""

import numpy as np

import contactfem as cf
from contactfem.run.api import Step

case = cf.Case.from_dict(
    {
        "title": "A block pressed on a plane",
        "time": {"end": "1 s", "step": "0.25 s"},
        "materials": {"steel": {"youngs_modulus": "200 GPa", "poisson_ratio": 0.3}},
        "bodies": {
            "pad": {
                "material": "steel",
                "mesh": {"builder": "block", "width": "4 mm", "height": "2 mm", "nx": 16, "ny": 8},
            }
        },
        "obstacles": {"floor": {"shape": "plane", "point": ["0 m", "0 m"], "normal": [0.0, 1.0]}},
        "interfaces": {"sole": {"nonmortar": "pad.bottom", "mortar": "floor"}},
        "conditions": [
            {"on": "pad.top", "displacement": ["0 mm", [["0 s", "0 mm"], ["1 s", "-10 um"]]]}
        ],
    }
)


def watch(step: Step) -> None:
    """Print the largest pressure of a step that was just accepted."""
    pressure = step.interfaces["sole"].pressure.max()
    print(f"t = {step.t:.2f} s  largest pressure {pressure / 1e6:.1f} MPa")


run = cf.solve(case, on_step=watch)

u = run.bodies["pad"].u  # a dolfinx Function: integrate it, interpolate it, write it
print(u.function_space.mesh.topology.dim, np.abs(u.x.array).max())
stress = run.bodies["pad"].stress
sole = run.interfaces["sole"]
print(sole.columns().keys())  # sole.to_pandas(), sole.plot("pressure")
