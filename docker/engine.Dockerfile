# The cloud, its containers and its simulated robots: one image, from this checkout, with all kernels compiled.
#   docker build -f docker/engine.Dockerfile -t ppaas-engine .
# Kernels are compiled for the CPU that builds, so build where it runs: on another CPU each container would compile anew.

FROM python:3.11-slim AS build
# The certificates of the base image are those that this network trusts.
ENV UV_NATIVE_TLS=1 UV_COMPILE_BYTECODE=1
WORKDIR /src
COPY deploy/bootstrap.lock deploy/requirements.lock deploy/
RUN python -m venv /opt/uv && /opt/uv/bin/pip install --quiet --require-hashes -r deploy/bootstrap.lock \
 && python -m venv --without-pip /opt/ppaas
COPY pyproject.toml ./
ARG EXTRAS="--extra cloud --extra sim --extra cassandra --extra hdfs"
RUN /opt/uv/bin/uv pip install --quiet --no-cache --python /opt/ppaas/bin/python \
      --constraints deploy/requirements.lock -r pyproject.toml $EXTRAS
COPY . .
RUN /opt/uv/bin/uv pip install --quiet --no-cache --python /opt/ppaas/bin/python --no-deps .

FROM python:3.11-slim
COPY --from=build /opt/ppaas /opt/ppaas
ENV PATH=/opt/ppaas/bin:$PATH NUMBA_CACHE_DIR=/opt/ppaas/kernels
# The root is read-only later: what Python and numba would write on their first day is written now.
RUN python -m engine.runtimes.rest_compiler \
 && python -OO -c "import engine.runtimes.preload, engine.rehearsed"
RUN python -OO -m compileall -q -x 'lib2to3|/tests?/' /usr/local/lib/python3.11 /opt/ppaas/lib \
 && useradd --system --uid 10001 --home-dir /var/lib/ppaas --create-home ppaas
USER ppaas
ENTRYPOINT ["ppaas"]
CMD ["up"]
