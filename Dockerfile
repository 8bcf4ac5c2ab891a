# One image for api, worker, sweep and prune: `docker build -t geoswarm .`, then `docker run geoswarm --help`.
FROM python:3.13.18-slim-trixie AS build
WORKDIR /build
# What does not change with every commit comes first: Docker keeps its result.
COPY requirements/image.txt requirements/
RUN python -m venv /opt/geoswarm \
 && /opt/geoswarm/bin/pip install --no-cache-dir --no-compile --disable-pip-version-check --require-hashes -r requirements/image.txt
COPY pyproject.toml hatch_build.py README.md LICENSE ./
COPY geoswarm geoswarm
COPY api api
COPY workers workers
COPY solver solver
COPY examples examples
COPY docs docs
RUN /opt/geoswarm/bin/pip install --no-cache-dir --no-compile --disable-pip-version-check --no-deps --no-build-isolation .
# Layers keep whole seconds of a file's time, and compiled code is only used while its source has the time that it had.
RUN find /opt/geoswarm -name '*.py' -exec touch -d '2000-01-01T00:00:00Z' {} + \
 && /opt/geoswarm/bin/python -m compileall -q -j 0 /opt/geoswarm/lib
# -P: for the installed package, not for the sources in this folder; kernels know the path of their source.
RUN NUMBA_CACHE_DIR=/opt/geoswarm/kernels /opt/geoswarm/bin/python -P -m geoswarm.solver.warm

FROM python:3.13.18-slim-trixie
RUN groupadd --system --gid 10001 geoswarm && useradd --system --uid 10001 --gid 10001 --create-home --home-dir /var/lib/geoswarm geoswarm
COPY LICENSE THIRD-PARTY-LICENSES.md /usr/share/doc/geoswarm/
COPY deploy/image/start /usr/local/bin/
COPY --from=build /opt/geoswarm /opt/geoswarm
USER geoswarm
WORKDIR /var/lib/geoswarm
# The root may be read-only: what is written at run time goes to /tmp.
ENV PATH=/opt/geoswarm/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    NUMBA_CACHE_DIR=/tmp/geoswarm-kernels \
    MPLCONFIGDIR=/tmp/geoswarm-matplotlib \
    OMP_NUM_THREADS=1 \
    OPENBLAS_NUM_THREADS=1
EXPOSE 8765
ENTRYPOINT ["start"]
CMD ["--help"]
