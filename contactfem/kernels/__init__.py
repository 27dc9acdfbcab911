"""C++ kernels of the interface behind a plain C interface (kernels.h), compiled at installation."""
