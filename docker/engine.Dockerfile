# The cloud, its containers and its simulated robots: one image, from this checkout, with all kernels compiled.
#   docker build -f docker/engine.Dockerfile -t ppaas-engine .
# Kernels are compiled for x86-64-v3 (processors since 2013); on one below, each container would compile them.
# A release gives the base by its digest, and the time of its commit (docs/releasing.md).

ARG PYTHON=python:3.11-slim
FROM ${PYTHON} AS dependencies
ARG SOURCE_DATE_EPOCH
# The certificates of the base image are those that this network trusts.
ENV UV_NATIVE_TLS=1
WORKDIR /src
COPY deploy/bootstrap.lock deploy/requirements.lock deploy/
RUN python -m venv /opt/uv && /opt/uv/bin/pip install --quiet --require-hashes -r deploy/bootstrap.lock \
 && python -m venv --without-pip /opt/ppaas
COPY pyproject.toml ./
RUN /opt/uv/bin/uv pip install --quiet --no-cache --python /opt/ppaas/bin/python \
      --constraints deploy/requirements.lock -r pyproject.toml \
      --extra cloud --extra sim --extra cassandra --extra hdfs \
      --extra metrics --extra backup --extra otel

# Kernels take minutes, and change seldom: nothing but what they are compiled from is here.
FROM dependencies AS kernels
WORKDIR /opt/ppaas/lib/python3.11/site-packages
COPY ppaas ppaas
COPY engine/__init__.py engine/
COPY engine/processes engine/processes
COPY engine/runtimes/__init__.py engine/runtimes/
COPY engine/runtimes/compilation engine/runtimes/compilation
COPY storage/__init__.py storage/
COPY storage/own_files.py storage/
RUN NUMBA_CACHE_DIR=/opt/ppaas/kernels /opt/ppaas/bin/python -m engine.runtimes.compilation.rest_compiler

FROM dependencies AS installed
COPY . .
# By pip: uv notes the time of the installation in what it installs.
RUN /opt/uv/bin/uv build --quiet --no-cache --wheel --build-constraints deploy/requirements.lock --require-hashes \
 && /opt/uv/bin/pip --python /opt/ppaas/bin/python install --quiet --no-index --no-deps --no-compile dist/*.whl

FROM ${PYTHON}
# With it Python notes the hash of a source in what it compiles from it, and not its time, which a release changes.
ARG SOURCE_DATE_EPOCH
RUN useradd --system --uid 10001 --home-dir /var/lib/ppaas --create-home ppaas \
 && chmod 700 /var/lib/ppaas && mkdir /tickets && chown ppaas /tickets
COPY --from=installed /opt/ppaas /opt/ppaas
COPY --from=kernels --chown=ppaas /opt/ppaas/kernels /opt/ppaas/kernels
ENV PATH=/opt/ppaas/bin:$PATH NUMBA_CACHE_DIR=/opt/ppaas/kernels PYTHONPYCACHEPREFIX=/opt/ppaas/modules
# The root is read-only later: what Python and numba would write on their first day is written now.
RUN for how in "" -OO; do python $how -m compileall -q -x 'lib2to3|/tests?/' /usr/local/lib/python3.11 /opt/ppaas/lib; done
USER ppaas
RUN python -OO -c "import engine.container.warm_up.preload, engine.container.warm_up.run"
ENTRYPOINT ["ppaas"]
CMD ["up"]
