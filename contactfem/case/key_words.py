"""Descriptions of the keys of a case file."""

MOTION = {
    "displacement": "motion over time, at rest if not given",
    "temperature": "temperature over time; without it no heat passes",
    "shape": "which kind of obstacle",
}
ARRAY = {
    "width": "size in x",
    "height": "size in y",
    "corner": "lower left corner",
    "nx": "cells in x",
    "ny": "cells in y",
    "cell": "kind of the cells",
    "pattern": "which diagonals split quadrilaterals into triangles",
    "grading": "size of the last cell over that of the first, in x and y",
}
BUILDER = {"builder": "which geometry"}
CIRCLE = {
    "center": "centre",
    "radius": "radius",
    "inner_radius": "radius of the hole",
    "outer_radius": "radius outside",
}
PETSC = {"petsc": "options of the linear solver, over the defaults"}

KEY_WORDS: dict[str, dict[str, str]] = {
    "Case": {
        "title": "what the case is, in a line",
        "references": "where it is from",
        "dimension": "what a plane mesh stands for",
        "strain": "finite, or small with the geometry of contact moving all the same",
        "time": "from when to when, in which steps",
        "materials": "by name",
        "bodies": "by name",
        "obstacles": "rigid counterparts, by name",
        "interfaces": "pairs of surfaces that may touch, by name",
        "mechanics": "whether bodies move",
        "adaptivity": "meshes and steps by estimated errors",
        "conditions": "what acts on bodies",
        "probes": "points to watch, by name",
        "closed_form": "known solutions to compare with, by the name of the interface",
        "solver": "Newton's method and the linear solver",
        "output": "what is written",
        "expect": "numbers that must come out, by name; false for none",
        "study": "what is the error of a run where runs are compared",
        "variants": "changes of keys that make another case, by name",
    },
    "Material": {
        "bulk_modulus": "K, with shear_modulus",
        "shear_modulus": "μ, with bulk_modulus",
        "youngs_modulus": "E, with poisson_ratio",
        "poisson_ratio": "ν, with youngs_modulus",
        "expansion": "linear thermal expansion α",
        "density": "ρ₀, per reference volume",
        "conductivity": "k",
        "heat_capacity": "c, per mass",
        "reference_temperature": "absolute temperature of the stress-free state",
        "parameters": "numbers for a user's energy, by name",
    },
    "Body": {"material": "name of its material", "mesh": "geometry with its mesh, or a mesh file"},
    "Plane": MOTION | {"point": "any point on it"},
    "Circle": MOTION | CIRCLE,
    "Polyline": MOTION | {"points": "its corners", "closed": "whether it returns to its start"},
    "Interface": {
        "nonmortar": "side that carries the multiplier",
        "mortar": "its counterpart",
        "search_radius": "how far apart the sides look for each other; by default a quarter of the "
        "nonmortar surface's extent, and two facets at least",
        "normal": "law of the pressure",
        "friction": "law of friction; false for none",
        "heat": "how heat passes",
    },
    "NormalLaw": {"law": "exact, or softened"},
    "Friction": {"law": "which law"},
    "InterfaceHeat": {
        "conductance": "h of law constant; h at p = hardness of law pressure",
        "hardness": "Vickers hardness of law pressure",
        "exponent": "exponent of law pressure",
        "gas_conductivity": "conductivity of the gas",
        "gas_distance": "thickness of the gas between surfaces in contact",
    },
    "Adaptivity": {
        "tolerance": 'relative error, such as 0.05 or "5 %"',
        "size_min": "smallest size of cells",
        "size_max": "largest size of cells",
        "growth": "of the size per distance, between neighbouring cells",
        "max_remeshes": "new meshes of one problem within one step",
    },
    "Condition": {
        "on": "a surface or a body",
        "displacement": "prescribed components; others stay free",
        "traction": "force per reference area",
        "pressure": "follows the surface, per current area",
        "body_force": "force per reference volume",
        "grip": "the surface moves as a rigid plate",
        "temperature": "prescribed temperature",
        "convection": "heat exchange with surroundings",
    },
    "Grip": {"displacement": "components that are led", "force": "components that are loaded"},
    "Convection": {"coefficient": "heat transfer coefficient", "ambient": "surroundings"},
    "Heat": PETSC,
    "Time": {
        "step_min": "smallest step; by default step / 1024",
        "step_max": "largest step; by default step",
    },
    "Solver": {
        "max_iterations": "Newton iterations before a step counts as failed",
        "max_cutbacks": "how often a step is halved before the run gives up",
    },
    "Output": {
        "fields": "for ParaView: one file of the run, a folder for each body (by ADIOS2), or none",
        "figures": "pictures",
    },
    "Probe": {
        "on": "body",
        "at": "reference position of the material point",
        "value": "what is watched there",
    },
    "Expectation": {"rel": "room, relative", "abs": "room, absolute"},
    "ClosedForm": {"solution": "which one", "parameters": "its numbers, by name"},
    "Block": BUILDER | ARRAY,
    "Wave": BUILDER
    | ARRAY
    | {"amplitude": "half of the height of the wave", "wavelength": "its length"}
    | {"crest": "x of a point that does not recede"},
    "Box": BUILDER | ARRAY | {"depth": "size in z", "nz": "cells in z"},
    "Cylinder": BUILDER | CIRCLE | {"cell": "kind of the cells", "part": "half or quarter"},
    "Die": BUILDER | CIRCLE,
    "Disk": BUILDER | CIRCLE,
    "Ring": BUILDER | CIRCLE,
    "GradedBlock": BUILDER | {"width": "size in x", "height": "size in y"},
    "Tire": BUILDER,
    "MeshFile": {"file": "gmsh's .msh, or what meshio reads"},
}
