"""C++ kernels of the interface behind a C interface (kernels.h)."""
