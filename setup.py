"""Packages and compiled kernels; everything else about contactfem is in pyproject.toml."""

from setuptools import find_packages, setup

setup(
    packages=[
        *find_packages(include=["contactfem", "contactfem.*"]),
        "contactfem.forms",
        "contactfem.meshes",
    ],
    package_dir={"contactfem.forms": "forms", "contactfem.meshes": "meshes"},
    cffi_modules=["contactfem/kernels/build.py:ffi"],
    # the kernels keep to the stable interface of Python: one wheel for 3.12 and all that follow
    options={"bdist_wheel": {"py_limited_api": "cp312"}},
)
