"""A run from Python instead of the command line, with a material of one's own."""

import sys
from pathlib import Path

from mpi4py import MPI

from contactfem.case import read_case
from contactfem.run import run_case

folder = Path(__file__).parent
out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs/script")

# any value of the case file may be changed on the way
case = read_case(folder / "pressed.toml", overrides=["materials.rubber.parameters.share=0.5"])
result = run_case(case, MPI.COMM_WORLD, out)

if MPI.COMM_WORLD.rank == 0:
    for step in result.steps:
        x, y = step.forces["sole"]  # on the floor [N/m]
        print(f"t = {step.t:.2f} s  {step.iterations} iterations  {x:10.1f} {y:10.1f} N/m")
    sole = result.interfaces[0]
    print(f"largest pressure {sole.pressure.max():.6g} Pa, smallest {sole.pressure.min():.6g} Pa")
    if not result.converged:
        sys.exit(result.message)
