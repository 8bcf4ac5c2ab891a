# One image for api, worker and sweep: `docker build -t geoswarm .`, then `docker run geoswarm --help`.
FROM python:3.12-slim AS build
WORKDIR /build
COPY pyproject.toml README.md LICENSE ./
COPY geoswarm geoswarm
COPY api api
COPY workers workers
COPY solver solver
RUN python -m venv /opt/geoswarm \
 && /opt/geoswarm/bin/pip install --no-cache-dir --disable-pip-version-check '.[server,plots,mesh,statistics]'

FROM python:3.12-slim
COPY --from=build /opt/geoswarm /opt/geoswarm
RUN useradd --system --uid 10001 --create-home --home-dir /var/lib/geoswarm geoswarm
USER geoswarm
WORKDIR /var/lib/geoswarm
# The kernels are compiled here once. The folder stays writable: on another kind of processor they are compiled again.
ENV PATH=/opt/geoswarm/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    NUMBA_CACHE_DIR=/var/lib/geoswarm/kernels \
    MPLCONFIGDIR=/var/lib/geoswarm/matplotlib \
    OMP_NUM_THREADS=1 \
    OPENBLAS_NUM_THREADS=1
RUN python -m geoswarm.solver.warm
EXPOSE 8765
ENTRYPOINT ["geoswarm"]
CMD ["--help"]
