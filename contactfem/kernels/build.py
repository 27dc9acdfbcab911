"""Compile the kernels into the extension module `contactfem._kernels` with cffi."""

import os
from pathlib import Path

import cffi

HERE = Path("contactfem/kernels")  # relative to the project's root, as setuptools demands
SOURCES = (
    "search", "segments", "mortar", "polygon_search", "polygon", "polygon_rows", "sparse",
)  # fmt: skip
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined", "-g"]


def declarations(header: str) -> str:
    """Keep of a C header what cffi's parser reads: no preprocessor, no linkage block."""
    lines = header.split('extern "C" {')[1].split("#ifdef __cplusplus\n}")[0].splitlines()
    return "\n".join(line for line in lines if not line.startswith("#"))


def builder() -> cffi.FFI:
    """Describe the extension; CONTACTFEM_SANITIZE=1 adds address and undefined-behaviour checks."""
    flags = SANITIZE if os.environ.get("CONTACTFEM_SANITIZE") == "1" else ["-O3"]
    ffi = cffi.FFI()
    ffi.cdef(declarations((HERE / "kernels.h").read_text()))
    ffi.set_source(
        "contactfem._kernels",
        '#include "kernels.h"',
        sources=[str(HERE / f"{name}.cpp") for name in SOURCES],
        include_dirs=[str(HERE)],
        source_extension=".cpp",
        extra_compile_args=["-std=c++17", "-Wall", "-Wextra", "-Werror", *flags],
        extra_link_args=SANITIZE if flags is SANITIZE else [],
    )
    return ffi


ffi = builder()

if __name__ == "__main__":
    ffi.compile(verbose=True)
