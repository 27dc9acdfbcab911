# contactfem on Debian 13. ./run uses the first stage only; `docker build -t contactfem .` gives an image with the program in it.
FROM debian:trixie-slim AS environment
COPY packaging/packages.txt packaging/install /packaging/
RUN /packaging/install && rm -r /packaging
ENV LC_ALL=C.UTF-8

FROM environment
COPY . /src
RUN pip install --root-user-action=ignore --break-system-packages --no-build-isolation --no-deps /src && rm -r /src
ENV OMP_NUM_THREADS=1 \
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 \
    OMPI_MCA_btl=self,sm OMPI_MCA_mpi_yield_when_idle=1 \
    PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
WORKDIR /cases
